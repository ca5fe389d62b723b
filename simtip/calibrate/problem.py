"""What a calibration estimates from what: the joint problem, its unknowns and its derivatives.

A point X of view i's target is at ``P_l = R_i X + t_i`` in the left camera and at
``P_r = R^T (P_l - T)`` in the right one (paper Eq. 19, ``P_l = R P_r + T``). The residual is the
pixel where it was seen less the pixel where the cameras' model puts it. Every unknown is there
once, so a view that only one camera saw counts for that camera and leaves R and T alone.

Rotations change by a small rotation vector w on the left, ``exp([w]x) R``: w is about the axes of
the left camera.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simtip.calibrate.corners import Corners
from simtip.calibrate.lens_model import LensModel
from simtip.geometry import Array

POSE = 6
"""Unknowns of a pose: a rotation vector, rad, and a translation, mm."""


@dataclass(frozen=True, eq=False)
class Problem:
    """The corners and the distortion model; without right corners, one camera alone.

    Attributes
    ----------
    left, right
        What each camera saw; only the left table may not be empty.
    views
        How many views there are; each is in at least one table.
    model
        Which distortion coefficients are estimated.
    """

    left: Corners
    right: Corners
    views: int
    model: LensModel

    @property
    def stereo(self) -> bool:
        """Whether there is a second camera."""
        return len(self.right) > 0

    @property
    def shared(self) -> int:
        """How many unknowns all views share: the cameras' and, of two, their relative pose."""
        free = len(self.model.free)
        return 2 * free + POSE if self.stereo else free

    @property
    def degrees_of_freedom(self) -> int:
        """Coordinates seen less unknowns."""
        seen = 2 * (len(self.left) + len(self.right))
        return seen - self.shared - POSE * self.views


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Values of all unknowns.

    Attributes
    ----------
    left, right
        (12,) fx, fy, cx, cy, px, then k1 k2 p1 p2 k3 k4 k5 k6.
    R, T
        (3, 3) and (3,) mm: ``P_l = R P_r + T``.
    turns, shifts
        (views, 3, 3) R_i and (views, 3) t_i, mm, of the boards: ``P_l = R_i X + t_i``.
    """

    left: Array
    right: Array
    R: Array
    T: Array
    turns: Array
    shifts: Array

    def moved(self, shared: Array, poses: Array, problem: Problem) -> Unknowns:
        """Take a step: `shared` (shared,) and `poses` (views, 6), as in `Problem`."""
        free = problem.model.free
        left, right, R, T = self.left.copy(), self.right, self.R, self.T
        left[free] += shared[: len(free)]
        if problem.stereo:
            right = right.copy()
            right[free] += shared[len(free) : 2 * len(free)]
            R = turned(shared[-6:-3], R)
            T = T + shared[-3:]
        turns = turned(poses[:, :3], self.turns)
        return replace(
            self,
            left=left,
            right=right,
            R=R,
            T=T,
            turns=turns,
            shifts=self.shifts + poses[:, 3:],
        )


def turned(rotation_vectors: Array, rotations: Array) -> Array:
    """Turn rotations (..., 3, 3) by rotation vectors (..., 3), rad: ``exp([w]x) R``."""
    product: Array = Rotation.from_rotvec(rotation_vectors).as_matrix() @ rotations
    return product


@dataclass(frozen=True, eq=False)
class Rows:
    """Residuals of one camera and their derivatives.

    Attributes
    ----------
    residual
        (n, 2) px, seen less modelled; infinite where a point is not in front of the camera.
    camera
        (n, 2, free) modelled pixels by the camera's free numbers.
    relative
        (n, 2, 6) by the relative pose; empty (n, 2, 0) for the left camera.
    board
        (n, 2, 6) by the pose of the view's target.
    """

    residual: Array
    camera: Array
    relative: Array
    board: Array


def residuals(problem: Problem, at: Unknowns) -> tuple[Array, Array]:
    """Give seen less modelled pixels, (n, 2) for the left and for the right camera."""
    P_l, P_r = _located(problem.left, at)[1], _located(problem.right, at)[1]
    left = problem.left.pixels - _pixels(at.left, P_l)
    right = problem.right.pixels - _pixels(at.right, (P_r - at.T) @ at.R)
    return left, right


def linearised(problem: Problem, at: Unknowns) -> tuple[Rows, Rows]:
    """Give the residuals and derivatives of both cameras."""
    free = problem.model.free
    RX, P = _located(problem.left, at)
    modelled, by_point, by_camera = _derivatives(at.left, P, free)
    nothing = np.zeros((len(P), 2, 0))
    left = Rows(problem.left.pixels - modelled, by_camera, nothing, _by_board(by_point, RX))
    RX, P = _located(problem.right, at)
    arm = P - at.T
    modelled, by_point, by_camera = _derivatives(at.right, arm @ at.R, free)
    by_left_point = by_point @ at.R.T
    # P_r = R^T (P_l - T): turning R by w turns the arm by -w
    relative = np.concatenate([_cross(by_left_point, arm), -by_left_point], axis=2)
    right = Rows(problem.right.pixels - modelled, by_camera, relative, _by_board(by_left_point, RX))
    return left, right


def _located(corners: Corners, at: Unknowns) -> tuple[Array, Array]:
    """Give R_i X and P_l = R_i X + t_i, both (n, 3) mm."""
    RX = np.einsum("nij,nj->ni", at.turns[corners.view], corners.points_mm)
    return RX, RX + at.shifts[corners.view]


def _by_board(by_point: Array, RX: Array) -> Array:
    return np.concatenate([-_cross(by_point, RX), by_point], axis=2)


def _cross(rows: Array, v: Array) -> Array:
    """Give each row a of (n, 2, 3) times [v]x, which is a x v, for v (n, 3)."""
    (a, b, c), (x, y, z) = np.moveaxis(rows, 2, 0), v.T[:, :, None]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=2)


def _pixels(numbers: Array, P: Array) -> Array:
    return _derivatives(numbers, P, np.zeros(0, dtype=np.intp))[0]


def _derivatives(numbers: Array, P: Array, free: NDArray[np.intp]) -> tuple[Array, Array, Array]:
    """Project points (n, 3): pixels (n, 2), and derivatives by the point and free numbers."""
    if not len(P):
        return np.zeros((0, 2)), np.zeros((0, 2, 3)), np.zeros((0, 2, len(free)))
    fx, fy, cx, cy = numbers[:4]
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    none = np.zeros(3)
    pixels, slopes = cv2.projectPoints(P.reshape(-1, 1, 3), none, none, K, numbers[4:])
    flat = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    # a point behind the camera has no pixel, and no step may lead there
    flat = np.where(P[:, 2:] > 0, flat, np.inf)
    # columns: 3 of the rotation, 3 of the point, then the camera's numbers in our order
    table = np.asarray(slopes, dtype=np.float64).reshape(len(P), 2, -1)
    return flat, table[:, :, 3:6], table[:, :, 6 + free]
