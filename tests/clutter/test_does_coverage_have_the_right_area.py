"""Does a drawn outline cover what it should, texel by texel, however small it is?

Oracle: points of a fine raster in each texel, by counting the outline's crossings to their right.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.clutter.coverage import area, coverage


def drawn(polygon, shape=(60, 60)):
    canvas = np.zeros(shape)
    for patch in coverage(polygon):
        h, w = patch.share.shape
        canvas[patch.row : patch.row + h, patch.col : patch.col + w] += patch.share
    return canvas


def star(centre, radius, corners, dent, turn):
    angle = turn + 2 * np.pi * np.arange(corners) / corners
    r = radius * np.where(np.arange(corners) % 2, 1 - dent, 1.0)
    return centre + np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)


def counted(polygon, row, col, fine=48):
    """Share of texel (row, col) inside, by even-odd crossings of fine x fine points."""
    at = (np.arange(fine) + 0.5) / fine
    x, y = np.meshgrid(col + at, row + at)
    inside = np.zeros_like(x, dtype=bool)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if y0 == y1:
            continue
        crosses = (y0 > y) != (y1 > y)
        inside ^= crosses & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return inside.mean()


STARS = st.builds(
    star,
    st.tuples(st.floats(25, 35), st.floats(25, 35)).map(np.array),
    st.floats(0.01, 20),
    st.integers(2, 20).map(lambda k: 2 * k),
    st.floats(0, 0.8),
    st.floats(0, 7),
)


@given(STARS, st.booleans())
@settings(derandomize=True, deadline=None, max_examples=60)
def test_the_area_is_the_outlines_whichever_way_round(polygon, back):
    outline = polygon[::-1] if back else polygon
    assert drawn(outline).sum() == pytest.approx(abs(area(outline)), rel=1e-9)


@given(STARS)
@settings(derandomize=True, deadline=None, max_examples=15)
def test_each_texel_has_its_own_share(polygon):
    canvas = drawn(polygon)
    low, high = np.floor(polygon.min(axis=0)).astype(int), np.floor(polygon.max(axis=0)).astype(int)
    rng = np.random.default_rng(1)
    for _ in range(12):
        col, row = rng.integers(low, high + 1)
        # The raster's error is at most its rows times the outline's crossings of them.
        assert canvas[row, col] == pytest.approx(counted(polygon, row, col), abs=0.04)


def test_a_rectangle_on_the_texels_lines_fills_them_and_no_others():
    canvas = drawn(np.array([[3.0, 4], [7, 4], [7, 50], [3, 50]]))
    expected = np.zeros((60, 60))
    expected[4:50, 3:7] = 1
    np.testing.assert_allclose(canvas, expected, atol=1e-12)


def test_a_quarter_texel_stays_in_its_texel():
    canvas = drawn(np.array([[3.5, 4.25], [4, 4.25], [4, 4.75], [3.5, 4.75]]))
    assert canvas[4, 3] == pytest.approx(0.25, rel=1e-12)
    canvas[4, 3] = 0
    assert canvas.max() < 1e-12


def test_a_long_thin_diagonal_keeps_its_width():
    along = np.array([50.0, 40.0]) / np.hypot(50, 40)
    across = np.array([-along[1], along[0]]) * 0.02
    ends = np.array([[4.3, 5.2], [54.3, 45.2]])
    canvas = drawn(np.concatenate([ends + across, (ends - across)[::-1]]))
    assert canvas.sum() == pytest.approx(0.04 * np.hypot(50, 40), rel=1e-9)
    assert canvas.max() < 0.1
