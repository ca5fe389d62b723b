"""Targets and photographs of them for the tests of the finder."""

from __future__ import annotations

import numpy as np
from oracles import board_photograph as photo

from simtip.find_target import find
from simtip.target import AsymmetricCircles, Charuco, Chessboard, CircleGrid, Sighting, Target

K_SMALL = np.array([[620.0, 0, 318.0], [0, 618.0, 243.0], [0, 0, 1]])
SMALL = (640, 480)
K_PAPER = np.array([[1875.0, 0, 1030.0], [0, 1875.0, 710.0], [0, 0, 1]])
PAPER = (2048, 1436)
LENS = np.array([-0.12, 0.08, 5e-4, -3e-4, 0])


def ink_of(target: Target) -> photo.Ink:
    """Give the print of a target by another way than its own."""
    if isinstance(target, Chessboard):
        return photo.chessboard(target.columns, target.rows, target.square_mm)
    if isinstance(target, Charuco):
        sizes = target.square_mm, target.marker_mm
        return photo.charuco(target.columns, target.rows, *sizes, target.dictionary)
    assert isinstance(target, CircleGrid | AsymmetricCircles)
    return photo.circles(target.points[:, :2], target.diameter_mm)


def photograph(
    target: Target,
    tilt_deg: float = 20.0,
    turn_deg: float = 40.0,
    roll_deg: float = 8.0,
    distance_mm: float = 100.0,
    seed: int = 0,
    camera: tuple[np.ndarray, tuple[int, int]] = (K_SMALL, SMALL),
    ink: photo.Ink | None = None,
    **look: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Give an 8-bit image (H, W), and the true pixels (n, 2) of all points."""
    middle = target.points[:, :2].mean(axis=0)
    rvec, tvec = photo.pose(tilt_deg, turn_deg, roll_deg, middle, np.array([2, -1, distance_mm]))
    light = {"blur_px": 0.8, "noise_dn": 1.0} | look
    camera_ = photo.Photographer(camera[0], camera[1], LENS, **light)
    box = np.array([target.low, target.high])
    image = camera_.shoot(ink or ink_of(target), box, rvec, tvec, seed)
    return image, camera_.pixels(target.points, rvec, tvec)


def seen(target: Target, image: np.ndarray) -> Sighting:
    """Find what has to be found."""
    outcome = find(target, image)
    assert isinstance(outcome, Sighting), outcome
    return outcome


def reason(target: Target, image: np.ndarray) -> str:
    """Say why a target is not found that must not be."""
    outcome = find(target, image)
    assert not isinstance(outcome, Sighting), "it was found"
    assert "\n" not in outcome.reason
    return outcome.reason


def half_turned(image: np.ndarray, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn an image and pixels in it upside down."""
    h, w = image.shape[:2]
    return image[::-1, ::-1], np.array([w - 1, h - 1]) - pixels


def mirrored(image: np.ndarray) -> np.ndarray:
    """Flip an image left to right."""
    return image[:, ::-1]
