"""What one sighting of a flat target tells before anything is calibrated: its homography."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from simtip.geometry import Array, unit
from simtip.target.sighting import Sighting

MIN_POINTS = 8
"""Fewer points than this say too little about a view: a homography alone takes four."""

MIN_WIDTH = 0.05
"""Least breadth of the seen points across their longest direction, as a share of their length."""

MAX_BEND = 0.03
"""Greatest median misfit to a homography, as a share of the target's size in the image: strong
lens distortion stays below 0.01, points with shuffled numbers are beyond 0.1."""


@dataclass(frozen=True, eq=False)
class Homography:
    """A flat target's way into an image, lens distortion neglected.

    Attributes
    ----------
    H
        (3, 3) takes homogeneous target coordinates (x, y), mm, to homogeneous pixels; points seen
        have a positive last coordinate.
    misfit
        Median distance between seen and mapped points, as a share of the target's size in the
        image.
    mirrored
        Whether it shows the target's back, or its mirror image.
    """

    H: Array
    misfit: float
    mirrored: bool


def fault_of(sighting: Sighting, points_mm: Array) -> str:
    """Say why a sighting cannot be used, in words that follow the camera's name; "" if it can."""
    if len(sighting.ids) < MIN_POINTS:
        return f"sees {len(sighting.ids)} points of the target; {MIN_POINTS} are needed"
    on_board = points_mm[sighting.ids, :2]
    sizes = np.linalg.svd(on_board - on_board.mean(axis=0), compute_uv=False)
    if sizes[1] < MIN_WIDTH * sizes[0]:
        return "sees points on one line of the target only"
    found = homography_of(sighting, points_mm)
    if found is None or found.misfit > MAX_BEND:
        size = "" if found is None else f": half of them are off by {found.misfit:.0%} of its size"
        return f"sees points that do not lie as on the target{size}"
    if found.mirrored:
        return "sees the target mirrored"
    return ""


def homography_of(sighting: Sighting, points_mm: Array) -> Homography | None:
    """Fit the homography of a sighting so that less than half of wrong points do no harm."""
    on_board, pixels = points_mm[sighting.ids, :2], sighting.pixels
    H, _ = cv2.findHomography(on_board, pixels, cv2.LMEDS)
    if H is None or not np.isfinite(H).all():
        return None
    mapped = np.column_stack([on_board, np.ones(len(on_board))]) @ H.T
    if np.median(mapped[:, 2]) < 0:
        H, mapped = -H, -mapped
    with np.errstate(all="ignore"):
        off = np.linalg.norm(mapped[:, :2] / mapped[:, 2:] - pixels, axis=1)
    size = float(np.linalg.norm(np.ptp(pixels, axis=0)))
    misfit = float(np.median(off)) / size if size > 0 else np.inf
    # x right, y down on the board and in the image: seen from the front, the turn is kept
    return Homography(np.asarray(H), misfit, mirrored=bool(np.linalg.det(H) < 0))


def normal_of(found: Homography, size: tuple[int, int]) -> Array:
    """Guess the unit normal (3,) of the target in the camera, for a lens like any other.

    The principal point is taken in the middle and the focal length as the image's longer side:
    wrong by a factor, which changes angles by about that factor, and leaves parallel parallel.
    """
    width, height = size
    focal = max(width, height)
    K = np.array(
        [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]], dtype=np.float64
    )
    vanishing = np.linalg.solve(found.H.T, np.array([0.0, 0.0, 1.0]))
    normal: Array = unit(K.T @ vanishing)
    return normal
