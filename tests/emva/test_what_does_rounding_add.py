"""The ripple of rounding against sums over the probabilities of the codes."""

import numpy as np
import pytest
from scipy import stats

from simtip.emva import rounding


def moments(mean, variance):
    """Mean and variance of a rounded normal number, by its probabilities."""
    codes = np.arange(-60, 61)
    edges = stats.norm.cdf((np.append(codes, 61) - 0.5 - mean) / np.sqrt(variance))
    share = np.diff(edges)
    found = share @ codes
    return found, share @ (codes - found) ** 2


@pytest.mark.parametrize("variance", [0.12, 0.157, 0.25, 0.35])
def test_the_ripple_has_the_stated_size(variance):
    phases = np.linspace(0, 1, 200, endpoint=False)
    exact = np.array([moments(phase, variance) for phase in phases])
    mean = np.sqrt(np.mean((exact[:, 0] - phases) ** 2))
    spread = np.sqrt(np.mean((exact[:, 1] - variance - 1 / 12) ** 2))
    assert rounding.mean_error(np.array(variance)) == pytest.approx(mean, rel=0.02)
    assert rounding.variance_error(np.array(variance)) == pytest.approx(spread, rel=0.05)


def test_pixels_that_differ_average_it_out():
    """Pixels spread normally about their mean, by quadrature."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(40)
    weights = weights / weights.sum()
    phases = np.linspace(0, 1, 50, endpoint=False)
    excess = [
        weights @ [moments(phase + 0.25 * x, 0.2)[1] - 0.2 - 1 / 12 for x in nodes]
        for phase in phases
    ]
    found = rounding.variance_error(np.array(0.2), 0.25**2)
    assert found == pytest.approx(np.sqrt(np.mean(np.square(excess))), rel=0.03)


def test_above_the_planned_noise_it_is_a_twelfth():
    exact = [moments(phase, 0.4) for phase in np.linspace(0, 1, 21)]
    assert max(abs(variance - 0.4 - 1 / 12) for _, variance in exact) < 1e-3
    assert rounding.variance_error(np.array(0.4)) < 1e-3


@pytest.mark.slow
def test_a_mean_frame_errs_no_more_than_stated():
    rng = np.random.default_rng(3)
    for noise, spread in ((0.1, 0.0), (0.16, 0.02), (0.25, 0.05), (0.4, 0.1)):
        for phase in np.linspace(0, 0.9, 10):
            pixels = phase + np.sqrt(spread) * rng.standard_normal(300)
            rounded = np.array([moments(x, noise)[0] for x in pixels])
            excess = np.var(rounded, ddof=1) - np.var(pixels, ddof=1)
            assert abs(excess) < 2.5 * rounding.spatial_error(noise, spread) + 1e-9
