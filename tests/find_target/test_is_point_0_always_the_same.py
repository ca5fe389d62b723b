from __future__ import annotations

import numpy as np
import pytest
from oracles import board_photograph as photo
from target_photographs import K_SMALL, half_turned, mirrored, photograph, reason, seen

from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Target

pytestmark = pytest.mark.slow

TELLING = [
    Chessboard(5, 4, 6.0),
    Charuco(5, 4, 6.0, 4.5),
    AsymmetricCircles(3, 5, 5.0, 4.0),
]
AMBIGUOUS = [
    Chessboard(6, 4, 6.0),
    Chessboard(5, 3, 6.0),
    CircleGrid(5, 3, 6.0, 3.0),
    AsymmetricCircles(3, 6, 5.0, 4.0),
]


@pytest.mark.parametrize("target", TELLING, ids=str)
@pytest.mark.parametrize("roll_deg", [100.0, 200.0])
def test_however_the_board_is_turned(target: Target, roll_deg: float):
    assert not target.half_turn_ambiguous
    image, truth = photograph(target, roll_deg=roll_deg, distance_mm=120.0)
    assert np.abs(seen(target, image).pixels - truth).max() < 0.2


@pytest.mark.parametrize("target", AMBIGUOUS, ids=str)
def test_else_it_is_at_the_upper_left_of_the_image(target: Target):
    assert target.half_turn_ambiguous
    image, truth = photograph(target)
    assert np.abs(seen(target, image).pixels - truth).max() < 0.2
    turned, there = half_turned(image, truth)
    assert np.abs(seen(target, turned).pixels - there[::-1]).max() < 0.2


def test_a_board_that_looks_the_same_four_ways_is_numbered_from_the_upper_left():
    target = Chessboard(4, 4, 6.0)
    assert target.quarter_turn_ambiguous
    image, truth = photograph(target, roll_deg=90.0)
    expected = truth.reshape(4, 4, 2)[::-1].transpose(1, 0, 2).reshape(-1, 2)
    assert np.abs(seen(target, image).pixels - expected).max() < 0.2


@pytest.mark.parametrize(
    "target",
    [Charuco(7, 5, 6.0, 4.5), Chessboard(7, 5, 6.0), AsymmetricCircles(4, 6, 5.0, 4.0)],
    ids=str,
)
def test_a_mirror_is_told(target: Target):
    assert target.chiral
    image, _ = photograph(target)
    assert "mirror" in reason(target, mirrored(image))


def test_a_board_with_colours_exchanged_is_named():
    image, _ = photograph(Chessboard(7, 5, 6.0), ink=photo.chessboard(7, 5, 6.0, first=1))
    assert "or the board is chessboard:5x7:6" in reason(Chessboard(7, 5, 6.0), image)
    assert len(seen(Chessboard(5, 7, 6.0), image)) == 35


def test_white_corners_do_not_matter_where_nothing_depends_on_them():
    target = Chessboard(6, 4, 6.0)
    image, truth = photograph(target, ink=photo.chessboard(6, 4, 6.0, first=1))
    assert np.abs(seen(target, image).pixels - truth).max() < 0.2


def test_part_of_a_charuco_board_is_enough():
    target = Charuco(7, 5, 6.0, 4.5)
    image, truth = photograph(target)
    cut = int(truth[2, 0])
    sighting = seen(target, image[:, cut:])
    inside = np.flatnonzero(truth[:, 0] > cut - 0.5)
    assert set(inside) >= set(sighting.ids)
    assert len(sighting) >= 0.8 * len(inside)
    assert np.abs(sighting.pixels + np.array([cut, 0]) - truth[sighting.ids]).max() < 0.1


def test_the_photographs_are_those_of_a_pinhole():
    """The truth itself: the middle of the board, upright, projects to its place."""
    target = Chessboard(7, 5, 6.0)
    _, truth = photograph(target, 0.0, roll_deg=0.0)
    ideal = K_SMALL[:2, 2] + np.array([2, -1]) / 100 * [620, 618]
    np.testing.assert_allclose(truth[17], ideal, atol=0.05)
