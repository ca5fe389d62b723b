"""The rectified frames and cameras in which ROS keeps the pose of a stereo pair.

The turn of each camera is shared half and half, then both are turned as little as it takes to bring
the baseline onto the x (or y) axis: the rule of `cv2.stereoRectify`, in closed form, so that the
pose comes back to rounding. OpenCV goes through the angle of R, which costs half of the digits when
that is small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.geometry import Array, skew, unit

MAX_OFF_AXIS = 10.0
"""Largest tangent of a rectified view's centre that the principal point makes up for."""


@dataclass(frozen=True, eq=False)
class Rectified:
    """Two parallel cameras in the place of a rig's.

    Attributes
    ----------
    R_left, R_right
        (3, 3) from each camera's frame to the rectified one.
    K
        (3, 3) of both, px.
    t_mm
        (3,) from left to right rectified coordinates, along one axis, x or y.
    """

    R_left: Array
    R_right: Array
    K: Array
    t_mm: Array


def rectify(rig: StereoRig) -> Rectified:
    """Find the parallel cameras that replace a rig's with the least turning."""
    T_rl = rig.T_lr.inverse()
    half = _half(T_rl.R)
    # Halfway, p_right = half^T^-1 p_halfway + t. Written with R, so that what follows is exact even
    # where half is not: next to half a turn.
    middle = half @ T_rl.R.T @ T_rl.t
    axis = 0 if abs(middle[0]) > abs(middle[1]) else 1
    aim = np.zeros(3)
    aim[axis] = 1.0 if middle[axis] > 0 else -1.0
    R_left = _turn(unit(middle), aim) @ half
    R_right = R_left @ T_rl.R.T
    K = _shared_intrinsics(rig, R_left, R_right, axis)
    return Rectified(R_left, R_right, K, aim * np.linalg.norm(T_rl.t))


def _half(R: Array) -> Array:
    """Give the rotation that makes R when done twice: the one nearest to I + R."""
    u, _, vt = np.linalg.svd(np.eye(3) + R)
    if np.linalg.det(u @ vt) < 0:  # at half a turn, where any sharing will do
        u[:, -1] *= -1
    root: Array = u @ vt
    return root


def _turn(start: Array, aim: Array) -> Array:
    """Give the least rotation from one unit vector to another, not opposite one."""
    cross = skew(np.cross(start, aim))
    turn: Array = np.eye(3) + cross + cross @ cross / (1.0 + start @ aim)
    return turn


def _shared_intrinsics(rig: StereoRig, R_left: Array, R_right: Array, axis: int) -> Array:
    """Choose intrinsics for both: the mean focal length across the baseline, as OpenCV 5 does.

    The principal point keeps the middles of the two views where they are, on average.
    """
    f = (rig.left.K[1 - axis, 1 - axis] + rig.right.K[1 - axis, 1 - axis]) / 2
    centre = (_centre(rig.left, R_left, f) + _centre(rig.right, R_right, f)) / 2
    return np.array([[f, 0, centre[0]], [0, f, centre[1]], [0, 0, 1]])


def _centre(camera: Camera, R: Array, f: float) -> Array:
    """Give the principal point with which the middle of the image stays in the middle."""
    middle = (np.array(camera.size) - 1) / 2
    x, y, z = R @ np.linalg.solve(camera.K, [*middle, 1.0])
    if max(abs(x), abs(y)) > MAX_OFF_AXIS * z:
        return middle
    kept: Array = middle - f * np.array([x, y]) / z
    return kept
