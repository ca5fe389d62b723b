"""Epipolar matching of the tips seen by two cameras (paper section 3.3).

With the fundamental matrix in the paper's order, ``p_l^T F p_r = 0`` (Eq. 12), a left point p_l has
the line ``F^T p_l`` in the right image, and a right point p_r the line ``F p_r`` in the left one.
The paper's Eq. 17 writes ``F P_l`` for the former, which would need the transposed F.

Points go in as pixels of the images as they are; they are undistorted first. Lines and distances
are those of the undistorted images, where an epipolar line is straight. For cameras without
distortion the two are the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from simtip.camera import StereoRig
from simtip.geometry import Array

MAX_DISTANCE_PX = 2.0
"""Section 3.3: the match is searched "with the region of 2 pixels" about the epipolar line."""

EPIPOLE_TOLERANCE = 1e-12
"""A line with a normal this short, relative to the sizes of F and the point, is only rounding."""


class MatchStatus(StrEnum):
    """Machine-readable outcome of a match."""

    OK = "ok"
    OFF_EPIPOLAR_LINE = "off_epipolar_line"
    AT_EPIPOLE = "at_epipole"
    OUTSIDE_LENS_MODEL = "outside_lens_model"


@dataclass(frozen=True, eq=False)
class StereoMatch:
    """Whether two image points can be the same point in space.

    Attributes
    ----------
    status
        ``ok``, or the code of the reason.
    reason
        One sentence with the numbers; empty when accepted.
    line_left, line_right
        (3,) a, b, c of the other view's epipolar line in this view, undistorted px,
        a^2 + b^2 = 1; NaN for a point at the epipole.
    distance_left_px, distance_right_px
        From the undistorted point to the line in its own view, at least 0. The right one is
        the paper's Eq. 17. None at the epipole.
    distance_px
        Symmetric distance: the mean of the two. None at the epipole.
    """

    status: MatchStatus
    reason: str
    line_left: Array
    line_right: Array
    distance_left_px: float | None
    distance_right_px: float | None
    distance_px: float | None

    @property
    def ok(self) -> bool:
        """Whether the match was accepted."""
        return self.status is MatchStatus.OK


def match_tips(
    tip_left_px: ArrayLike,
    tip_right_px: ArrayLike,
    rig: StereoRig,
    max_distance_px: float = MAX_DISTANCE_PX,
) -> StereoMatch:
    """Accept two tips as one if their symmetric epipolar distance is small enough.

    Parameters
    ----------
    tip_left_px, tip_right_px
        (2,) u, v in px of the images as they are.
    rig
        The calibrated cameras.
    max_distance_px
        Largest accepted symmetric distance, inclusive, px.

    Raises
    ------
    ValueError
        A tip is not two finite numbers.
    """
    left, right = _point(tip_left_px), _point(tip_right_px)
    line_left = epipolar_line_left(right, rig)
    line_right = epipolar_line_right(left, rig)
    undistorted = rig.left.undistort(left), rig.right.undistort(right)
    if not np.isfinite(undistorted).all():
        reason = "the rig's distortion has no ray for a tip: it is not valid there"
        return StereoMatch(
            MatchStatus.OUTSIDE_LENS_MODEL, reason, line_left, line_right, None, None, None
        )
    if np.isnan([line_left, line_right]).any():
        reason = "a tip lies on the line through both cameras, so it has no epipolar line"
        return StereoMatch(MatchStatus.AT_EPIPOLE, reason, line_left, line_right, None, None, None)
    d_left = float(distance_to_line(undistorted[0], line_left))
    d_right = float(distance_to_line(undistorted[1], line_right))
    distance = (d_left + d_right) / 2
    status, reason = MatchStatus.OK, ""
    if not distance <= max_distance_px:
        status = MatchStatus.OFF_EPIPOLAR_LINE
        reason = (
            f"the tips are {distance:.2f} px from each other's epipolar lines "
            f"(left {d_left:.2f}, right {d_right:.2f}); {max_distance_px:g} px is allowed"
        )
    return StereoMatch(status, reason, line_left, line_right, d_left, d_right, distance)


def epipolar_line_right(tip_left_px: ArrayLike, rig: StereoRig) -> Array:
    """Give the line in the right image for points of the left image: ``F^T p_l``.

    Parameters
    ----------
    tip_left_px
        (..., 2), px of the left image as it is.
    rig
        The calibrated cameras.

    Returns
    -------
    Array
        (..., 3) a, b, c with ``a u + b v + c = 0`` in undistorted px of the right image and
        a^2 + b^2 = 1; NaN where the point is the epipole.
    """
    return epipolar_lines(rig.left.undistort(tip_left_px), rig.fundamental().T)


def epipolar_line_left(tip_right_px: ArrayLike, rig: StereoRig) -> Array:
    """Give the line in the left image for points of the right image: ``F p_r``.

    As `epipolar_line_right`, with the views exchanged.
    """
    return epipolar_lines(rig.right.undistort(tip_right_px), rig.fundamental())


def epipolar_distances(
    left_px: ArrayLike, right_px: ArrayLike, rig: StereoRig
) -> tuple[Array, Array]:
    """Give the distances of paired points from each other's epipolar lines.

    Parameters
    ----------
    left_px, right_px
        (..., 2) paired points, px of the images as they are.
    rig
        The calibrated cameras.

    Returns
    -------
    left, right
        (...) px, at least 0, in the undistorted left and right image; their mean is the
        symmetric distance of `StereoMatch`. NaN where a point is an epipole.
    """
    in_left = distance_to_line(rig.left.undistort(left_px), epipolar_line_left(right_px, rig))
    in_right = distance_to_line(rig.right.undistort(right_px), epipolar_line_right(left_px, rig))
    return in_left, in_right


def epipolar_lines(points_px: ArrayLike, F: ArrayLike) -> Array:
    """Give the lines ``F p``, scaled to a^2 + b^2 = 1.

    Parameters
    ----------
    points_px
        (..., 2) undistorted px.
    F
        (3, 3), of any scale, that takes these points to lines of the other image.

    Returns
    -------
    Array
        (..., 3); NaN where the point is the epipole.
    """
    uv = np.asarray(points_px, dtype=np.float64)
    p = np.concatenate([uv, np.ones((*uv.shape[:-1], 1))], axis=-1)
    matrix = np.asarray(F, dtype=np.float64)
    lines: Array = p @ matrix.T
    length = np.linalg.norm(lines[..., :2], axis=-1, keepdims=True)
    size = np.linalg.norm(p, axis=-1, keepdims=True) * np.linalg.norm(matrix[:2])
    defined = length > EPIPOLE_TOLERANCE * size
    return np.where(defined, lines / np.where(defined, length, 1.0), np.nan)


def distance_to_line(points_px: ArrayLike, lines: ArrayLike) -> Array:
    """Give the distance (...) px of points (..., 2) from lines (..., 3) with a^2 + b^2 = 1."""
    uv = np.asarray(points_px, dtype=np.float64)
    abc = np.asarray(lines, dtype=np.float64)
    distance: Array = np.abs((uv * abc[..., :2]).sum(axis=-1) + abc[..., 2])
    return distance


def _point(tip_px: ArrayLike) -> Array:
    point = np.asarray(tip_px, dtype=np.float64)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise ValueError("a tip is two finite numbers, u and v")
    return point
