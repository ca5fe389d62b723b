from __future__ import annotations

import cv2
import numpy as np
import pytest
from oracles import board_photograph as print_

from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Target

CASES = [
    (Chessboard(), print_.chessboard(11, 8, 6.0)),
    (Chessboard(4, 3, 2.5), print_.chessboard(4, 3, 2.5)),
    (
        Charuco(12, 9, 6.0, 4.5, "DICT_4X4_100"),
        print_.charuco(12, 9, 6.0, 4.5, "DICT_4X4_100"),
    ),
    # Rows even and columns odd, and a larger marker: the numbering of markers differs.
    (Charuco(5, 8, 8.0, 6.4, "DICT_6X6_50"), print_.charuco(5, 8, 8.0, 6.4, "DICT_6X6_50")),
]


@pytest.mark.parametrize(("target", "ink"), CASES, ids=lambda c: str(c)[:24])
def test_ink_agrees_with_another_drawing(target: Target, ink: print_.Ink):
    # OpenCV draws whole pixels, 80 a square: at the middle of each there is no doubt.
    step = target.pitch_mm / 80
    n = np.round((target.high - target.low) / step).astype(int)
    x = target.low[0] + (np.arange(-100, n[0] + 100, 7) + 0.5) * step
    y = target.low[1] + (np.arange(-100, n[1] + 100, 7) + 0.5) * step
    st = np.column_stack([np.tile(x, len(y)), np.repeat(y, len(x))])
    black = target.ink(st)
    np.testing.assert_array_equal(black, ink(st[:, 0], st[:, 1]))
    assert 0.1 < black.mean() < 0.8


@pytest.mark.parametrize(
    "target", [CircleGrid(5, 4, 6.0, 3.0), AsymmetricCircles(4, 11, 6.0, 7.0)], ids=str
)
def test_circles_are_black_up_to_their_radius(target: CircleGrid | AsymmetricCircles):
    x = np.random.default_rng(1).uniform(target.low - 5, target.high + 5, (20000, 2))
    distance = np.linalg.norm(x[:, None] - target.points[None, :, :2], axis=2).min(axis=1)
    np.testing.assert_array_equal(target.ink(x) > 0.5, distance <= target.diameter_mm / 2)


@pytest.mark.parametrize("target", [c[0] for c in CASES] + [CircleGrid(5, 4, 6, 3)], ids=str)
def test_the_box_holds_all_ink_and_is_no_larger(target: Target):
    x = np.random.default_rng(2).uniform(target.low - 9, target.high + 9, (200000, 2))
    black = x[target.ink(x) > 0.5]
    assert (black >= target.low).all()
    assert (black <= target.high).all()
    np.testing.assert_allclose(black.min(axis=0), target.low, atol=0.1)
    np.testing.assert_allclose(black.max(axis=0), target.high, atol=0.1)


def test_points_are_in_the_order_of_opencv():
    board = cv2.aruco.CharucoBoard(
        (7, 5), 6.0, 4.5, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    )
    theirs = np.asarray(board.getChessboardCorners())
    np.testing.assert_allclose(Charuco(7, 5, 6.0, 4.5).points, theirs - theirs[0], atol=1e-5)
    asymmetric = [((2 * j + i % 2) * 6.0, i * 6.0, 0) for i in range(11) for j in range(4)]
    np.testing.assert_allclose(AsymmetricCircles(4, 11, 6.0, 3.0).points, asymmetric)
    rows = [(i * 6.0, j * 6.0, 0) for j in range(8) for i in range(11)]
    np.testing.assert_allclose(Chessboard().points, rows)
    np.testing.assert_allclose(CircleGrid(11, 8, 6.0, 3.0).points, rows)
