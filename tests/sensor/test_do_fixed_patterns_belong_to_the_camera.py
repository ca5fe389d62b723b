"""Are fixed patterns a camera's own: the same in all its frames, cut with its region, seeded?"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from simtip import sensor
from simtip.seeding import stream
from simtip.spec import CameraSpec, SensorSpec

SPEC = SensorSpec(
    exposure_s=0.1,
    prnu_percent=2,
    dsnu_e=10,
    hot_fraction=0.01,
    dead_fraction=0.02,
    hot_current_e_per_s=5000,
    bit_depth=12,
    gain_dn_per_e=0.4,
    black_level_dn=50,
)


def camera(width=120, height=90, roi=None):
    return CameraSpec(width=width, height=height, fx=1, fy=1, cx=0, cy=0, roi=roi)


def changed(**changes):
    return SPEC.model_copy(update=changes)


def equal(a, b):
    return all(
        np.array_equal(getattr(a, name), getattr(b, name)) for name in ("response", "dsnu_e", "hot")
    )


def test_the_pattern_is_the_cameras_and_not_the_calls():
    first = sensor.fixed_pattern(SPEC, camera(), "left")
    for other in (changed(exposure_s=1.0), changed(fixed_pattern_seed=3), changed(prnu_percent=1)):
        sensor.fixed_pattern(other, camera(), "left")
        sensor.fixed_pattern(other, camera(), "right")
    assert equal(first, sensor.fixed_pattern(changed(exposure_s=0.2), camera(), "left"))


@pytest.mark.parametrize("other", [("right", 0), ("left", 1)])
def test_another_side_or_seed_is_another_camera(other):
    side, seed = other
    first = sensor.fixed_pattern(SPEC, camera(), "left")
    second = sensor.fixed_pattern(changed(fixed_pattern_seed=seed), camera(), side)
    bound = 4 / np.sqrt(first.response.size)
    alive = (first.response > 0) & (second.response > 0)
    for name in ("response", "dsnu_e"):
        a, b = getattr(first, name)[alive], getattr(second, name)[alive]
        assert abs(np.corrcoef(a, b)[0, 1]) < bound
    assert not np.array_equal(first.hot, second.hot)


def test_prnu_and_dsnu_channels_and_neighbours_are_independent():
    pattern = sensor.fixed_pattern(changed(dead_fraction=0), camera(400, 300), "left")
    r, d = pattern.response, pattern.dsnu_e
    pairs = [(r, d), (r[..., 0], r[..., 1]), (r[:, 1:], r[:, :-1]), (d[1:], d[:-1])]
    for a, b in pairs:
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(a.size)


def test_spread_and_shape_are_as_stated():
    """Normal by Kolmogorov and Smirnov; shares of defects by their binomial error."""
    pattern = sensor.fixed_pattern(SPEC, camera(400, 300), "left")
    n = pattern.response.size
    alive = pattern.response[pattern.response > 0]
    assert stats.kstest((alive - 1) / 0.02, "norm").pvalue > 1e-3
    assert stats.kstest(pattern.dsnu_e.ravel() / 10, "norm").pvalue > 1e-3
    for found, share in ((n - alive.size, 0.02), (pattern.hot.size, 0.01)):
        assert found == pytest.approx(n * share, abs=4 * np.sqrt(n * share))


def test_a_region_of_interest_shows_its_part():
    whole = sensor.fixed_pattern(SPEC, camera(), "left")
    part = sensor.fixed_pattern(SPEC, camera(roi=[31, 12, 50, 40]), "left")
    window = np.s_[12:52, 31:81]
    np.testing.assert_array_equal(part.response, whole.response[window])
    np.testing.assert_array_equal(part.dsnu_e, whole.dsnu_e[window])
    hot = np.zeros((90, 120, 3), dtype=bool)
    hot.reshape(-1)[whole.hot] = True
    np.testing.assert_array_equal(part.hot, np.flatnonzero(hot[window]))


def test_a_larger_figure_scales_the_same_pattern():
    one = sensor.fixed_pattern(changed(dead_fraction=0), camera(), "left")
    two = sensor.fixed_pattern(
        changed(dead_fraction=0, prnu_percent=4, dsnu_e=20), camera(), "left"
    )
    np.testing.assert_allclose(two.response - 1, 2 * (one.response - 1), atol=3e-7)
    np.testing.assert_allclose(two.dsnu_e, 2 * one.dsnu_e, rtol=1e-6)


def test_without_figures_nothing_is_kept():
    plain = SensorSpec(exposure_s=0.1)
    assert equal(sensor.fixed_pattern(plain, camera(), "left"), sensor.UNIFORM)


def test_nobody_can_change_a_pattern_that_is_shared():
    pattern = sensor.fixed_pattern(SPEC, camera(), "left")
    for array in (pattern.response, pattern.dsnu_e, pattern.hot):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_hot_and_dead_pixels_are_where_the_pattern_says():
    """Without noise: 500 e- more in hot ones; dead ones show their dark signal and the rest."""
    spec = changed(noise=False, dsnu_e=0)
    pattern = sensor.fixed_pattern(spec, camera(), "left")
    light = np.broadcast_to(2000 / sensor.responsivity(spec), (90, 120, 3))
    image = sensor.expose(light, spec, camera=pattern, rng=stream(1))
    electrons = 2000 * pattern.response.astype(np.float64)
    electrons.reshape(-1)[pattern.hot] += 500
    np.testing.assert_array_equal(image, np.rint(0.4 * electrons + 50))
    assert (image[pattern.response == 0] <= 250).all()
    crop = sensor.fixed_pattern(spec, camera(roi=[7, 5, 60, 50]), "left")
    cut = sensor.expose(light[5:55, 7:67], spec, camera=crop, rng=stream(1))
    np.testing.assert_array_equal(cut, image[5:55, 7:67])


def test_a_pattern_of_another_size_is_refused():
    pattern = sensor.fixed_pattern(SPEC, camera(), "left")
    with pytest.raises(ValueError, match="fixed pattern has the shape"):
        sensor.expose(np.zeros((90, 121, 3)), SPEC, camera=pattern, rng=stream(1))


@pytest.mark.slow
def test_every_pixel_has_its_own_mean_over_a_thousand_frames():
    """The mean of each pixel against `expected_dn`: chi-square over 3 x 24 x 32 pixels.

    The spread of the pixels' means gives PRNU and DSNU back, by EMVA 1288's difference of a lit
    and a dark series; errors of variances over n pixels are sqrt(2 / n).
    """
    spec = changed(
        dead_fraction=0, full_well_e=1e5, bit_depth=16, gain_dn_per_e=2, black_level_dn=200
    )
    pattern = sensor.fixed_pattern(spec, camera(32, 24), "left")
    spread = []
    for mean_e in (1000.0, 0.0):
        light = np.broadcast_to(mean_e / sensor.responsivity(spec), (24, 32, 3)).astype(np.float32)
        total = np.zeros((24, 32, 3))
        rng = stream(2, "frames")
        for _ in range(1000):
            total += sensor.expose(light, spec, camera=pattern, rng=rng)
        mean = total / 1000
        expected = sensor.expected_dn(light, spec, camera=pattern)
        collected = mean_e * pattern.response.astype(np.float64)
        collected.reshape(-1)[pattern.hot] += 500
        variance = 4 * (collected + 25) + 1 / 12
        chi2 = ((mean - expected) ** 2 / (variance / 1000)).sum()
        assert stats.chi2.sf(chi2, mean.size) > 1e-3
        assert stats.chi2.cdf(chi2, mean.size) > 1e-3
        mean.reshape(-1)[pattern.hot] = np.nan
        spread.append((np.nanvar(mean, ddof=1) - np.nanmean(variance) / 1000) / 4)
    lit, dark = spread
    n = pattern.response.size
    assert np.sqrt(dark) == pytest.approx(10, rel=2 / np.sqrt(n / 2))
    assert np.sqrt(lit - dark) / 1000 == pytest.approx(0.02, rel=2.5 / np.sqrt(n / 2))
