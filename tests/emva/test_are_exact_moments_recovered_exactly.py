"""Fed with the moments of a camera instead of samples, the evaluation must give it back exactly."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from simtip.emva import Level, MeanFrame, Series, characterise
from simtip.emva.transfer import _Columns
from simtip.errors import InputError

K, SIGMA, ETA, RATE, BLACK, TIME, WELL = 0.5, 8.0, 0.55, 300.0, 40.0, 0.02, 7000
PRNU, DSNU = 0.011, 3.0
SHAPE = (40, 50)


def clipped(mean):
    """Mean and variance of min(Poisson, WELL)."""
    n = np.arange(WELL)
    share = stats.poisson.pmf(n, mean)
    over = stats.poisson.sf(WELL - 1, mean)
    first = share @ n + over * WELL
    return first, share @ (n - first) ** 2 + over * (WELL - first) ** 2


def level(photons, exposure_s=TIME, frames=8):
    first, second = clipped(ETA * photons + RATE * exposure_s)
    return Level(photons, exposure_s, BLACK + K * first, K**2 * (second + SIGMA**2) + 1 / 12,
                 frames, SHAPE[0] * SHAPE[1])  # fmt: skip


def pattern():
    """Two patterns of exactly the stated spread, without correlation."""
    rng = np.random.default_rng(0)
    raw = rng.standard_normal((2, SHAPE[0] * SHAPE[1]))
    raw -= raw.mean(axis=1, keepdims=True)
    first = raw[0] / np.std(raw[0], ddof=1)
    second = raw[1] - first * (first @ raw[1]) / (first @ first)
    return first.reshape(SHAPE), (second / np.std(second, ddof=1)).reshape(SHAPE)


def flat(photons, frames=32):
    mean = level(photons, frames=frames)
    response, offset = pattern()
    picture = mean.mean_dn + K * (PRNU * ETA * photons * response + DSNU * offset)
    return MeanFrame(mean, picture, 0.0)


def series():
    top = WELL / ETA
    photons = [0, *np.linspace(top / 40, top, 40), *(top * np.array([1.02, 1.05, 1.5, 2]))]
    return Series(
        tuple(level(p) for p in photons),
        tuple(level(0.0, t) for t in (0.02, 0.5, 1, 2)),
        (flat(0.0), flat(top / 2)),
    )


def test_all_come_back_to_rounding():
    found = characterise(series(), bit_depth=12)
    for estimate, truth in [
        (found.K_dn_per_e, K),
        (found.sigma_d_e, SIGMA),
        (found.dark_current_e_per_s, RATE),
        (found.dark_current_by_variance_e_per_s, RATE),
        (found.full_well_e, WELL),
        (found.snr_max, WELL**0.5),
        (found.quantum_efficiency, ETA),
        (found.black_level_dn, BLACK),
        (found.prnu_percent, 100 * PRNU),
        (found.dsnu_e, DSNU),
    ]:
        assert estimate.value == pytest.approx(truth, rel=1e-9)
        assert estimate.low < truth < estimate.high
    assert found.notes == ()
    assert found.full_well_limit == "well"


def test_the_standards_saturation_is_the_peak_of_the_clipped_variance():
    """It lies below the clip by some root(WELL), which is why it is not called full well."""
    found = characterise(series(), bit_depth=12)
    means = np.linspace(0.9 * WELL, 1.02 * WELL, 400)
    peak = means[np.argmax([clipped(mean)[1] for mean in means])] - RATE * TIME
    low, high = found.saturation_capacity_e.low, found.saturation_capacity_e.high
    assert low <= peak <= high
    assert 1.5 * WELL**0.5 < WELL - peak < 4 * WELL**0.5
    assert high < WELL


def test_the_interval_of_k_is_that_of_weighted_least_squares():
    """Against the closed form for proportional noise: each level gives K to sqrt(2 / n)."""
    found = characterise(series(), bit_depth=12)
    used = [x for x, fit in zip(found.photon_transfer, found.in_fit, strict=True) if fit]
    freedom = 4 * (SHAPE[0] * SHAPE[1] - 1)
    design = np.array([[1, x.mean_dn - BLACK] for x in used])
    weight = np.array([freedom / (2 * x.variance_dn2**2) for x in used])
    dark = np.array([x.photons == 0 for x in used])
    weight[dark] *= [x.frames // 2 / 4 for x in used if x.photons == 0]
    covariance = np.linalg.inv(design.T @ (design * weight[:, None]))
    half = 2.5758 * covariance[1, 1] ** 0.5
    assert found.K_dn_per_e.high - found.K_dn_per_e.value == pytest.approx(half, rel=0.02)


def test_the_variance_of_a_variance_is_that_of_single_electrons():
    """Few Poisson electrons are far from normal: against all pairs and their probabilities."""
    gain, mean_e = 4.0, 0.7
    n = np.arange(40)
    share = stats.poisson.pmf(n, mean_e)
    half_square = (gain * (n[:, None] - n)) ** 2 / 2
    both = share[:, None] * share
    first = (both * half_square).sum()
    exact = (both * (half_square - first) ** 2).sum()
    rows = _Columns([Level(1.0, 1.0, 0.0, 0.0, frames=2, pixels=2)])
    noise = np.array([gain**2 * mean_e - 1 / 12])
    found = rows.variance_error(noise, np.array([gain * mean_e]), gain, np.zeros(1))
    assert found[0] == pytest.approx(exact, rel=1e-6)


def test_the_temporal_noise_left_in_mean_frames_is_taken_off():
    clean = series()
    noisy = []
    for frame in clean.flats:
        left = frame.level.variance_dn2 / frame.level.frames
        # Scale the pattern up to what the left-over noise would make of it.
        centred = frame.mean_dn - frame.mean_dn.mean()
        factor = np.sqrt(1 + left / np.var(centred, ddof=1))
        noisy.append(MeanFrame(frame.level, frame.mean_dn.mean() + factor * centred, left))
    found = characterise(replace(clean, flats=tuple(noisy)), bit_depth=12)
    assert found.dsnu_e.value == pytest.approx(DSNU, rel=1e-9)
    assert found.prnu_percent.value == pytest.approx(100 * PRNU, rel=1e-9)


def test_without_saturation_there_is_no_full_well_but_a_gain():
    whole = series()
    short = tuple(x for x in whole.transfer if x.photons < 0.6 * WELL / ETA)
    found = characterise(replace(whole, transfer=short), bit_depth=12)
    assert found.K_dn_per_e.value == pytest.approx(K, rel=1e-9)
    assert found.full_well_e.value is None
    assert "plateau" in found.full_well_e.reason
    assert found.saturation_capacity_e.value is None
    assert found.to_dict()["ci99"]["full_well_e"] is None
    assert "full_well_e" in found.to_dict()["reasons"]


def test_what_is_not_measured_is_missing_with_a_reason():
    found = characterise(Series(series().transfer), bit_depth=12)
    for estimate in (found.dark_current_e_per_s, found.prnu_percent, found.dsnu_e):
        assert estimate.value is None
        assert estimate.reason
    assert any("shot noise" in note for note in found.notes)


def test_noise_too_small_for_whole_dn_is_no_gain():
    """K = 0.001 DN/e-: under the well all noise is below the rounding."""
    tiny = tuple(
        replace(x, mean_dn=x.mean_dn / 500, variance_dn2=(x.variance_dn2 - 1 / 12) / 500**2)
        for x in series().transfer
    )
    found = characterise(Series(tiny), bit_depth=12)
    assert found.K_dn_per_e.value is None
    assert "0.48 DN^2" in found.K_dn_per_e.reason


def test_a_bent_photon_transfer_is_said_and_widens_the_interval():
    straight = series()
    bent = tuple(
        replace(x, variance_dn2=x.variance_dn2 * (1 + 0.2 * (x.mean_dn / 3500) ** 2))
        for x in straight.transfer
    )
    found = characterise(replace(straight, transfer=bent), bit_depth=12)
    assert any("no straight line" in note for note in found.notes)
    before = characterise(straight, bit_depth=12).K_dn_per_e
    after = found.K_dn_per_e
    assert after.high - after.low > 1.5 * (before.high - before.low)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: replace(s, transfer=s.transfer[1:]),
        lambda s: replace(s, transfer=()),
        lambda s: replace(s, transfer=(*s.transfer, level(50.0, 0.5))),
        lambda s: replace(s, dark=(*s.dark, level(50.0, 0.5))),
    ],
)
def test_series_that_fit_no_measurement_are_refused(change):
    with pytest.raises(InputError):
        characterise(change(series()), bit_depth=12)
