"""Is the noise Poisson plus normal, unbiased after rounding, and reproducible?"""

from __future__ import annotations

import numpy as np
import pytest
from emva_oracle import dn_probabilities, moments
from scipy import stats

from simtip import sensor
from simtip.seeding import stream
from simtip.sensor import chain
from simtip.spec import SensorSpec

SPEC = SensorSpec(exposure_s=0.04, black_level_dn=3)
SHAPE = (256, 1024)
N = SHAPE[0] * SHAPE[1]


def light_for(mean_e, spec=SPEC, shape=SHAPE):
    """Irradiance for which each pixel collects `mean_e` on average in all channels."""
    return np.broadcast_to(mean_e / sensor.responsivity(spec), (*shape, 3)).astype(np.float32)


def take(light, spec, rng):
    return sensor.expose(light, spec, camera=sensor.UNIFORM, rng=rng)


def reaching(mu, n):
    """The w from which on the drawn number is at least n, by bisection; u = 1 adds nothing."""
    mu, n = np.broadcast_arrays(mu, n)
    one = np.ones(n.shape, np.float32)
    low, high = np.full(n.shape, -8.0), np.full(n.shape, 8.0)
    for _ in range(50):
        middle = (low + high) / 2
        reached = sensor.poisson_quantile(mu, middle, one) >= n
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return high


@pytest.mark.parametrize("mu", [0.0625, 1, 7.5, 31.9375, 32, 33.3, 1000, 10000])
def test_more_w_never_gives_fewer_electrons(mu):
    """Without this, bisection would not see the whole of a distribution."""
    w = np.linspace(-7.99, 7.99, 100_001)
    drawn = sensor.poisson_quantile(np.full(w.shape, float(mu)), w, np.ones(w.shape, np.float32))
    assert (np.diff(drawn) >= 0).all()


def distribution(below, n):
    return np.diff(np.concatenate([[0], below, [1]])), np.concatenate([[n[0] - 1], n])


@pytest.mark.parametrize("mu", [sensor.TABLE_BELOW_E, 33.3, 50, 100.25, 1000, 10000])
def test_the_quantile_expansion_is_poisson(mu):
    """No sampling: where the expansion first reaches n, at w, P(X < n) is Phi(w).

    w is found by bisection in double precision and Phi(w) compared with Poisson's own
    distribution function. The bounds are those of the docstring.
    """
    n = np.arange(max(1, int(mu - 7 * mu**0.5)), int(mu + 7.5 * mu**0.5))
    p, value = distribution(stats.norm.cdf(reaching(float(mu), n)), n)
    p_true, _ = distribution(stats.poisson.cdf(n - 1, mu), n)
    assert np.abs(p - p_true).sum() / 2 < 1.3e-5 * min(1, 32 / mu) ** 2 + 1e-10
    mean = p @ value
    assert mean == pytest.approx(p_true @ value, abs=1e-9)
    assert p @ (value - mean) ** 2 == pytest.approx(mu, rel=3e-5)


def test_the_table_is_poisson_in_every_row():
    """No sampling: the thresholds in w, for every multiple of 1/16 e- below 32, are Poisson's.

    In double precision, but for the thresholds, which are single: 2^-24 of |w| phi(w) each.
    """
    mu, n = np.arange(512)[:, None] / 16, np.arange(1, 100)
    p, p_true = (
        np.diff(below, axis=1, prepend=0, append=1)
        for below in (stats.norm.cdf(reaching(mu, n)), stats.poisson.cdf(n - 1, mu))
    )
    assert (np.abs(p - p_true).sum(axis=1) / 2 < 3e-7).all()
    np.testing.assert_allclose(p @ np.arange(100), mu[:, 0], atol=1e-6)


@pytest.mark.parametrize("delta", [0.0, 1e-6, 0.01, 0.0624])
@pytest.mark.parametrize("k", [0, 1, 511])
def test_what_is_left_between_the_rows_is_poisson(k, delta):
    """Over an even grid of u, single precision, the count beyond the row's is Poisson(delta)."""
    u = ((np.arange(2**20) + 0.5) / 2**20).astype(np.float32)
    mean, w = np.full(u.shape, k / 16 + delta), np.full(u.shape, 0.3)
    extra = sensor.poisson_quantile(mean, w, u) - sensor.poisson_quantile(mean, w, u * 0 + 1)
    p = np.bincount(extra.astype(int), minlength=5)[:5] / u.size
    np.testing.assert_allclose(p, stats.poisson.pmf(np.arange(5), delta), atol=2 / u.size)


def test_a_pixel_of_no_light_stays_empty_whatever_the_dice():
    w = np.array([-9, -3, 0, 3, 7.9, 9], dtype=np.float32)
    for u in (0, 2**-24, 0.5):
        drawn = sensor.poisson_quantile(w * 0, w, np.full(w.shape, u, dtype=np.float32))
        np.testing.assert_array_equal(drawn, 0)


def test_more_light_on_one_pixel_leaves_the_others_noise():
    """From 8 e- to 5000 e- in one pixel: a sharper use of equal seeds than equal bytes."""
    light = light_for(20.0, shape=(16, 16))
    before = take(light, SPEC, stream(12))
    light[5, 6, 1] *= 600
    after = take(light, SPEC, stream(12))
    assert np.argwhere(before != after).tolist() == [[5, 6, 1]]


@pytest.mark.parametrize("mu", [0.02, 1.5, 9.99, 31.9, 32.0, 75.3, 400.0])
def test_drawn_electrons_are_poisson_distributed(mu):
    """Chi-square over the single numbers of electrons, rare ones gathered at both ends."""
    drawn = sensor.shot_noise(np.full(400_000, mu, dtype=np.float32), stream(2, "poisson"))
    assert drawn.dtype == np.float32
    assert (drawn == np.floor(drawn)).all()
    mu = float(np.float32(mu))
    edges = np.arange(stats.poisson.ppf(2e-5, mu), stats.poisson.ppf(1 - 2e-5, mu) + 1)
    counts = np.histogram(drawn, np.concatenate([[-np.inf], edges + 0.5, [np.inf]]))[0]
    cdf = np.concatenate([[0], stats.poisson.cdf(edges, mu), [1]])
    assert stats.chisquare(counts, np.diff(cdf) * 400_000).pvalue > 1e-3


@pytest.mark.parametrize("mean_e", [0.0, 4.0, 31.0, 33.0, 250.0, 3000.0, 7071.5])
def test_the_image_has_the_exact_distribution(mean_e):
    """Chi-square of 786,432 pixels against the summed probabilities, black level included."""
    image = take(light_for(mean_e), SPEC, stream(3, "image"))
    expected = dn_probabilities(mean_e, SPEC) * image.size
    counts = np.bincount(image.ravel(), minlength=256)
    common = expected > 10
    observed = np.append(counts[common], counts[~common].sum())
    predicted = np.append(expected[common], expected[~common].sum())
    if predicted[-1] < 1:  # too rare to test: join the commonest
        observed, predicted = (
            observed[:-1],
            predicted[:-1] * observed[:-1].sum() / predicted[:-1].sum(),
        )
    assert stats.chisquare(observed, predicted, sum_check=False).pvalue > 1e-3


@pytest.mark.parametrize("mean_e", [200.0, 2000.0, 7000.0])
def test_the_mean_is_unbiased(mean_e):
    """To 4 standard errors, below 0.01 DN: SD / sqrt(3 N) is 0.0024 DN at 7000 e-."""
    image = take(light_for(mean_e), SPEC, stream(4, "mean"))
    tolerance = 4 * np.sqrt((SPEC.gain_dn_per_e**2 * (mean_e + 25) + 1 / 12) / image.size)
    assert tolerance < 0.01
    expected = SPEC.gain_dn_per_e * mean_e + 3
    # Rounding itself biases by at most exp(-2 pi^2 s^2) / pi, s^2 the variance before it, DN^2.
    rounding = np.exp(-2 * np.pi**2 * SPEC.gain_dn_per_e**2 * (mean_e + 25)) / np.pi
    assert abs(image.mean(dtype=np.float64) - expected) < tolerance + rounding


def test_no_light_is_lost_in_the_dark():
    """A fine gain, so that an electron is 4 DN: the mean is right to 0.01 DN from 0 e- on.

    Black level 30 keeps the read noise off zero. Standard errors: 4 sqrt(mu + 4) / sqrt(3 N).
    """
    spec = SPEC.model_copy(
        update={"gain_dn_per_e": 4.0, "read_noise_e": 2.0, "black_level_dn": 30.0}
    )
    for mean_e in (0.0, 0.1, 1.0, 5.0, 20.0, 31.99, 32.01):
        image = take(light_for(mean_e, spec), spec, stream(5, "dark"))
        true_mean, true_variance = moments(dn_probabilities(mean_e, spec))
        tolerance = 4 * np.sqrt(true_variance / image.size)
        assert abs(image.mean(dtype=np.float64) - true_mean) < tolerance
        if mean_e <= 20:  # brighter ones reach the range's end
            assert true_mean == pytest.approx(30 + 4 * mean_e, abs=0.01)


@pytest.mark.slow
def test_single_precision_does_not_bias_bright_pixels():
    """At a million electrons float32 has steps of 1/16: the mean holds to 2^-24 of itself.

    Tested on the drawn electrons: 4 standard errors are 4 x 1000 / sqrt(4e6) = 2 e-, 0.0005 DN of
    an 8-bit camera that is full there.
    """
    drawn = sensor.shot_noise(np.full(4_000_000, 1e6, dtype=np.float32), stream(6))
    assert abs(drawn.mean(dtype=np.float64) - 1e6) < 2
    assert drawn.var(dtype=np.float64) == pytest.approx(1e6, rel=4 * np.sqrt(2 / 4e6))


@pytest.mark.slow
def test_the_photon_transfer_gives_back_gain_and_read_noise():
    """EMVA 1288: variance = K (mean - black) + K^2 sigma_d^2 + 1/12, from pairs of images.

    A variance over n values has a relative standard error of sqrt(2 / n), here 0.16 %; the fit's
    own covariance then gives the tolerances, 4 standard errors. From 700 e- on the spread is
    above 0.68 DN, and the rounding's variance within 1e-4 of 1/12.
    """
    levels = np.array([700.0, 1200, 2000, 3000, 4500, 6000, 7500])
    mean, variance = [], []
    for k, level in enumerate(levels):
        a, b = (
            take(light_for(level), SPEC, stream(7, k, name)).astype(np.float64)
            for name in ("a", "b")
        )
        mean.append((a.mean() + b.mean()) / 2 - SPEC.black_level_dn)
        variance.append((a - b).var() / 2)
    weight = 1 / (np.array(variance) * np.sqrt(2 / a.size))
    (slope, intercept), covariance = np.polyfit(mean, variance, 1, w=weight, cov="unscaled")
    slope_error, intercept_error = 4 * np.sqrt(np.diag(covariance))
    assert slope_error < 0.005 * SPEC.gain_dn_per_e
    assert intercept_error < 0.008  # the read noise gives 0.016, the rounding 0.083
    assert abs(slope - SPEC.gain_dn_per_e) < slope_error
    assert abs(intercept - (0.0255 * 5) ** 2 - 1 / 12) < intercept_error


def test_the_same_seed_gives_the_same_bytes_and_another_side_others():
    light = light_for(500.0, shape=(64, 64))
    left, again, right, other = (
        take(light, SPEC, stream(seed, "sensor", side))
        for seed, side in ((1, "left"), (1, "left"), (1, "right"), (2, "left"))
    )
    np.testing.assert_array_equal(left, again)
    assert (left != right).mean() > 0.3
    assert (left != other).mean() > 0.3
    correlation = np.corrcoef(left.ravel(), right.ravel())[0, 1]
    assert abs(correlation) < 4 / np.sqrt(left.size)


def test_one_generator_used_twice_gives_two_pictures():
    rng = stream(1)
    light = light_for(500.0, shape=(64, 64))
    first, second = (take(light, SPEC, rng) for _ in range(2))
    assert (first != second).mean() > 0.3


def test_pixels_and_channels_are_independent():
    """Neighbours and channels share no noise: correlations within 4 / sqrt(n)."""
    image = take(light_for(5000.0), SPEC, stream(8)).astype(np.float64)
    image -= image.mean(axis=(0, 1))
    pairs = [
        (image[:, 1:], image[:, :-1]),
        (image[1:], image[:-1]),
        (image[..., 0], image[..., 1]),
        (image[..., 1], image[..., 2]),
    ]
    for a, b in pairs:
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(a.size)


@pytest.mark.parametrize("block", [1, 777, 10**9])
def test_the_size_of_the_working_blocks_changes_nothing(block, monkeypatch):
    ramp = np.linspace(0, 1, 37 * 53 * 3).reshape(37, 53, 3)
    light = (light_for(300.0, shape=(37, 53)) * ramp).astype(np.float32)  # both sides of 32 e-
    before = take(light, SPEC, stream(9))
    monkeypatch.setattr(chain, "_BLOCK", block)
    np.testing.assert_array_equal(take(light, SPEC, stream(9)), before)


def test_read_noise_off_leaves_the_shot_noise_as_it_was():
    light = light_for(500.0, shape=(64, 64))
    fine = SPEC.model_copy(update={"gain_dn_per_e": 0.25})
    loud = take(light, fine, stream(10)).astype(float)
    quiet = take(light, fine.model_copy(update={"read_noise_e": 0.0}), stream(10))
    assert (loud - quiet).std() == pytest.approx(np.sqrt((0.25 * 5) ** 2 + 1 / 6), rel=0.05)


def test_double_precision_light_gives_the_same_picture():
    light = light_for(500.0, shape=(64, 64))
    single, double = (
        take(light.astype(kind), SPEC, stream(11)) for kind in (np.float32, np.float64)
    )
    assert (single != double).mean() < 1e-3
