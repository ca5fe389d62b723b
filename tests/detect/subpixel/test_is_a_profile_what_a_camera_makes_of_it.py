"""Are the tables across a needle those of a fine band, blurred and averaged over square pixels?"""

import numpy as np
import pytest

from simtip.detect.subpixel.edge_table import INSIDE, OUTSIDE, EdgeTables, modes

CASES = [(10.0, 0.0, 0.5), (4.3, 0.6, 0.05), (30.0, -0.35, 2.2), (3.0, 1.0, 0.003)]
"""Half width, slope, variance of the blur."""


def amplitudes(seed):
    return np.random.default_rng(seed).normal(0, 1, INSIDE + OUTSIDE)


def band(x, half, amplitude):
    """Give the light at distances x from the axis, of constant, modes and background."""
    theta, columns = modes()
    inside = np.interp(np.arcsin(np.clip(x / half, -1, 1)), theta, columns @ amplitude[:INSIDE])
    left, right, slope = amplitude[INSIDE:]
    outside = np.where(x < 0, left, right) + slope * x / half
    return np.where(np.abs(x) < half, inside, outside)


def seen(x, half, slope, variance, amplitude):
    """Give what pixels at distances x see: the mean of many points, each in a Gaussian's shares."""
    spots = (np.arange(24) + 0.5) / 24 - 0.5
    along, across = np.meshgrid(spots, spots)
    cosine, sine = 1 / np.hypot(1, slope), slope / np.hypot(1, slope)
    square = (along * cosine - across * sine).reshape(-1)
    reach = 6 * np.sqrt(variance)
    blur = np.linspace(-reach, reach, 151)
    share = np.exp(-0.5 * blur**2 / variance)
    fine = np.arange(-half - 16, half + 16, 1 / 512)  # the same for all x and all blurs
    light = band(fine, half, amplitude)
    shares = zip(blur, share / share.sum(), strict=True)
    blurred = sum(s * np.interp(fine + b, fine, light) for b, s in shares)
    return np.interp(x[:, None] + square, fine, blurred).mean(axis=1)


def tables(half, reach, slope, variance):
    return EdgeTables.build(half, reach, np.array([slope]), np.array([variance]))


def test_each_blur_of_several_has_the_tables_it_would_have_alone():
    blurs = [(slope, variance) for _, slope, variance in CASES]
    together = EdgeTables.build(9.4, 14, *np.array(blurs).T)
    x = np.linspace(-13, 13, 101)
    for k, blur in enumerate(blurs):
        alone = tables(9.4, 14, *blur).at(x)
        assert together.at(x, k) == pytest.approx(alone, abs=1e-3)


@pytest.mark.parametrize(("half", "slope", "variance"), CASES)
def test_the_profile_is_the_mean_of_many_points(half, slope, variance):
    amplitude = amplitudes(1)
    x = np.linspace(-half - 4, half + 4, 157)
    table = tables(half, half + 5, slope, variance).at(x)
    assert table[:, 0] @ amplitude == pytest.approx(
        seen(x, half, slope, variance, amplitude), abs=0.01
    )


@pytest.mark.parametrize(("half", "slope", "variance"), CASES[:3])
def test_the_derivatives_are_those_of_the_many_points(half, slope, variance):
    amplitude = amplitudes(2)
    x = np.linspace(-half - 3, half + 3, 101)
    _, by_x, by_variance = np.moveaxis(tables(half, half + 4, slope, variance).at(x), 1, 0)
    h = 0.05
    ahead, behind = (seen(x + d, half, slope, variance, amplitude) for d in (h, -h))
    assert by_x @ amplitude == pytest.approx((ahead - behind) / (2 * h), abs=0.03)
    h = 0.1 * variance
    more, less = (seen(x, half, slope, variance + d, amplitude) for d in (h, -h))
    assert by_variance @ amplitude == pytest.approx((more - less) / (2 * h), abs=0.03)
