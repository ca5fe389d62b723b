"""Are only pixels averaged that lie as far from the axis?"""

import numpy as np
import pytest

from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_pixels import BIN_PX, BINS_MERGED, merge, sort_pixels

ROWS = np.arange(400)


def pixels(lean):
    """Give the pixels beside a shaft that leans by so many px, as bright as distance squared."""
    shaft = Shaft(
        399.0,
        400.0,
        np.array([60.2, lean]),
        np.array([9.0, 0.0]),
        np.full(2, 0.3),
        np.array([1.0, 0.0]),
        np.zeros((0, 0)),
        np.inf,
    )
    away = np.arange(120) - shaft.axis_u(ROWS.astype(float))[:, None]
    return sort_pixels(((away / np.hypot(1, lean / 400)) ** 2).astype(np.float32), ROWS, shaft)


@pytest.mark.parametrize("lean", [0.0, 0.4, 3.0, 90.0])
def test_the_averages_are_of_like_pixels(lean):
    bins = pixels(lean)
    for one, width in ((bins, BIN_PX), (merge(bins), BINS_MERGED * BIN_PX)):
        # Less the square of the mean: their variance, which is at most that of both ends.
        spread = (one.value - one.x**2)[one.count > 0]
        assert spread.max() < (width / 2) ** 2 + 1e-4


def test_whole_columns_along_an_upright_shaft_are_not_averaged_with_each_other():
    bins = pixels(0.0)
    merged = merge(bins)
    assert merged.x.shape[1] == bins.x.shape[1]
    assert merged.x[0] == pytest.approx(bins.x[0])


def test_of_a_leaning_shaft_neighbouring_bins_are_merged():
    bins = pixels(90.0)
    merged = merge(bins)
    assert merged.count.sum() == bins.count.sum()
    np.testing.assert_array_equal(merged.number, np.unique(bins.number // BINS_MERGED))
    assert len(merged.number) < 0.6 * len(bins.number)
