"""Does a place on the board look the same whatever part of the board is asked for?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from simtip.clutter import board_texture
from simtip.clutter.grid import MAX_TEXELS, Grid
from simtip.errors import InputError
from simtip.spec.background import BackgroundSpec, Gradient, PaperTexture, Wrinkles
from simtip.spec.clutter import ClutterSpec

PAPER = BackgroundSpec(
    paper=PaperTexture(contrast=0.03), gradient=Gradient(), wrinkles=Wrinkles(folds=3)
)
CLUTTER = ClutterSpec(level="hostile")
FIELDS = ("albedo", "clutter")


@pytest.fixture(scope="module")
def whole():
    return board_texture(PAPER, CLUTTER, 3, (-40, -30), (45, 35))


def cut(texture, part):
    """The part of a larger texture that a smaller one covers."""
    i, j = np.rint((part.corner_mm - texture.corner_mm) / texture.step_mm).astype(int)
    rows, cols = part.albedo.shape
    return {name: getattr(texture, name)[j : j + rows, i : i + cols] for name in FIELDS}


@pytest.mark.slow
@given(
    st.tuples(st.floats(-39, 30), st.floats(-29, 20)),
    st.tuples(st.floats(0.05, 14), st.floats(0.05, 14)),
)
@example((5.0, 5.0), (3.0, 3.0))
@example((-20.0, -20.0), (3.0, 3.0))
@settings(derandomize=True, deadline=None, max_examples=12)
def test_any_box_shows_the_same_board(whole, low, size):
    part = board_texture(PAPER, CLUTTER, 3, low, np.add(low, size))
    expected = cut(whole, part)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(part, name), expected[name])
    i, j = np.rint((part.slope_corner_mm - whole.slope_corner_mm) / whole.slope_step_mm).astype(int)
    rows, cols, _ = part.slope.shape
    np.testing.assert_array_equal(part.slope, whole.slope[j : j + rows, i : i + cols])


def test_there_is_something_to_compare(whole):
    assert whole.clutter.max() == 1
    assert whole.albedo.std() > 0.02
    assert min(whole.prints.values()) > 0


def test_prints_and_grain_do_not_depend_on_the_boards_size():
    plain = PAPER.model_copy(update={"gradient": None})
    small = plain.model_copy(update={"size_mm": (100.0, 90.0)})
    a, b = (board_texture(x, CLUTTER, 3, (-9, -9), (9, 9)) for x in (plain, small))
    np.testing.assert_array_equal(a.albedo, b.albedo)


def test_the_texels_are_where_they_say():
    """A gradient alone gives each texel's place away."""
    gradient = Gradient(ratio=3, direction_deg=0)
    linear = BackgroundSpec(size_mm=(100, 100), albedo=(0.1, 0.1, 0.1), gradient=gradient)
    texture = board_texture(linear, ClutterSpec(), 3, (-33.3, -12), (41, 17))
    s = texture.corner_mm[0] + texture.step_mm * np.arange(texture.albedo.shape[1])
    np.testing.assert_allclose(texture.albedo[0], 1 + 0.5 * s / 50, atol=1e-6)
    assert texture.corner_mm[0] <= -33.3
    assert s[-1] >= 41


def test_seeds_decide_paper_and_prints_each_on_its_own():
    box = (-10.0, -10.0), (10.0, 10.0)
    first, again, other = (board_texture(PAPER, CLUTTER, s, *box) for s in (1, 1, 2))
    np.testing.assert_array_equal(first.albedo, again.albedo)
    assert (first.clutter != other.clutter).any()
    assert (first.slope != other.slope).any()
    sheet = PAPER.model_copy(update={"texture_seed": 1})
    same_paper = board_texture(sheet, CLUTTER, 2, *box)
    np.testing.assert_array_equal(same_paper.slope, first.slope)
    np.testing.assert_array_equal(same_paper.clutter, other.clutter)
    strewn = CLUTTER.model_copy(update={"seed": 1})
    same_prints = board_texture(PAPER, strewn, 2, *box)
    np.testing.assert_array_equal(same_prints.clutter, first.clutter)
    np.testing.assert_array_equal(same_prints.slope, other.slope)


def test_a_large_box_gets_larger_texels():
    grid = Grid.over((-400, -400), (400, 400), 0.1)
    assert 0.5 * MAX_TEXELS < np.prod(grid.shape) <= MAX_TEXELS
    s, t = grid.axes()
    assert s[0] <= -400 < s[1] + 1e-9
    assert t[-2] - 1e-9 < 400 <= t[-1]


def test_a_board_beyond_sense_is_refused_with_a_remedy():
    vast = BackgroundSpec(size_mm=(1e5, 1e5))
    with pytest.raises(InputError, match="board"):
        board_texture(vast, CLUTTER, 0, (-5e4, -5e4), (5e4, 5e4))
    grainy = BackgroundSpec(size_mm=(1e5, 1e5), paper=PaperTexture())
    with pytest.raises(InputError, match="too much to hold"):
        board_texture(grainy, ClutterSpec(), 0, (-5e4, -5e4), (5e4, 5e4))
