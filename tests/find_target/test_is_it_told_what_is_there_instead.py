from __future__ import annotations

import cv2
import numpy as np
import pytest
from target_photographs import photograph, reason, seen

from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Target, parse_target

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("there", "stated", "told"),
    [
        ("chessboard:7x4:6", "chessboard:6x4:6", "a board of 7x4 inner corners is there"),
        ("chessboard:7x4:6", "chessboard:9x6:6", "a lattice of 7x4 inner corners is in sight"),
        ("circles:7x4:6:3", "circles:6x4:6:3", "a board of 7x4 circles is there"),
        ("asymmetric:3x7:5:4", "asymmetric:3x6:5:4", "a board of 3x7 circles is there"),
        ("charuco:7x5:6:4.5", "charuco:5x7:6:4.5", "another size of board"),
        ("charuco:7x5:6:4.5", "charuco:7x5:6:3.5", "the markers are about 4."),
    ],
)
def test_another_size(there: str, stated: str, told: str):
    image, _ = photograph(parse_target(there), blur_px=1.0, distance_mm=90.0)
    assert told in reason(parse_target(stated), image)


@pytest.mark.parametrize(
    ("there", "stated", "told"),
    [
        ("chessboard:7x4:6", "chessboard:5x3:6", "a board of 7x4 inner corners is there"),
        ("chessboard:7x4:6", "circles:7x4:6:3", "circles"),
        ("chessboard:7x4:6", "charuco:8x5:6:4", "no markers of DICT_4X4_50"),
        ("circles:7x4:6:3", "circles:8x4:6:3", "a lattice of 7x4 circles is in sight"),
        ("circles:7x4:6:3", "circles:7x4:6:2", "another diameter"),
        ("circles:7x4:6:3", "circles:7x4:6:4.5", "another diameter"),
        ("circles:7x4:6:3", "chessboard:7x4:6", "inner corners"),
        ("charuco:7x5:6:4.5", "charuco:7x5:6:4.5:DICT_5X5_50", "of DICT_4X4_1000"),
    ],
)
def test_another_target(there: str, stated: str, told: str):
    image, _ = photograph(parse_target(there), blur_px=1.0, distance_mm=90.0)
    assert told in reason(parse_target(stated), image)


def test_a_charuco_board_of_before_4_6():
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((7, 6), 6.0, 4.5, words)
    board.setLegacyPattern(True)
    image = board.generateImage((560, 480), marginSize=20)
    assert "before 4.6" in reason(Charuco(7, 6, 6.0, 4.5), image)


@pytest.mark.parametrize("target", [Chessboard(7, 4, 6.0), Charuco(7, 5, 6.0, 4.5)], ids=str)
def test_a_covered_point_is_left_out_and_the_others_stay(target: Target):
    image, truth = photograph(target)
    u, v = np.rint(truth[12]).astype(int)
    image[v - 14 : v + 15, u - 14 : u + 15] = 120
    sighting = seen(target, image)
    assert 12 not in sighting.ids or target.half_turn_ambiguous
    assert len(target.points) - 9 <= len(sighting) < len(target.points)
    off = np.linalg.norm(sighting.pixels[:, None] - truth[None], axis=2).min(axis=1)
    assert off.max() < 0.3


@pytest.mark.parametrize("target", [Chessboard(5, 4, 6.0), CircleGrid(5, 4, 6.0, 3.0)], ids=str)
def test_a_point_that_is_covered_in_part_is_not_dragged_along(target: Target):
    image, truth = photograph(target, noise_dn=0.5)
    u, v = np.rint(truth[7]).astype(int)
    image[v - 12 : v + 13, u + 3 : u + 20] = 70
    sighting = seen(target, image)
    assert len(sighting) >= len(target.points) - 4
    off = np.linalg.norm(sighting.pixels[:, None] - truth[None], axis=2).min(axis=1)
    assert off.max() < 0.05


def test_a_board_that_leaves_the_image_is_not_found():
    target = Chessboard(7, 4, 6.0)
    image, truth = photograph(target)
    cut = image[:, int(truth[:, 0].min()) + 20 :]
    assert "outside of the image" in reason(target, cut)


def test_an_asymmetric_grid_is_no_symmetric_one():
    image, _ = photograph(AsymmetricCircles(3, 7, 5.0, 4.0))
    assert "circles" in reason(CircleGrid(7, 3, 5.0, 4.0), image)
