"""The rigid motion between two frames, and how uncertain it leaves a point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.capability.interval import Array

FLATNESS = 1e-6
"""Points on a line: their second extent is below this share of the first."""


@dataclass(frozen=True)
class Registration:
    """``target = R source + t``, by least squares.

    Attributes
    ----------
    R, t
        (3, 3) rotation, det +1, and (3,) translation, mm.
    residuals
        (n, 3) target - (R source + t), mm.
    centroid
        (3,) mean of the target points, mm.
    axes, extents
        (3, 3) principal axes of the target points about it, as rows, and (3,) the root mean
        square of their coordinates along each, mm.
    """

    R: Array
    t: Array
    residuals: Array
    centroid: Array
    axes: Array
    extents: Array

    @property
    def fre(self) -> float:
        """Fiducial registration error: root mean square length of the residuals, mm."""
        return math.sqrt(float((self.residuals**2).sum()) / len(self.residuals))

    @property
    def fle_variance(self) -> float:
        """Variance of one coordinate of a point's error in one frame against the other, mm^2.

        Sum of squares over its 3 n - 6 degrees of freedom; errors isotropic and independent. Its
        triple is <FLE^2> of Fitzpatrick (1998): <FRE^2> = (1 - 2 / n) <FLE^2>.
        """
        return float((self.residuals**2).sum()) / (self.residuals.size - 6)

    @property
    def covariance(self) -> Array:
        """Covariance (6, 6) of small rotations about the centroid, rad, and of translation, mm.

        Order: rotations about x, y, z of the target frame, then x, y, z.
        """
        n = len(self.residuals)
        # A rotation w moves a point q by w x q: information sum(|q|^2 I - q q^T).
        squares = n * self.extents**2
        about = squares.sum() - squares
        found = np.zeros((6, 6))
        found[:3, :3] = self.fle_variance * (self.axes.T / about) @ self.axes
        found[3:, 3:] = self.fle_variance / n * np.eye(3)
        return found

    def apply(self, points: ArrayLike) -> Array:
        """Take source points (..., 3) to the target frame, mm."""
        moved: Array = np.asarray(points, dtype=np.float64) @ self.R.T + self.t
        return moved

    def tre_covariance(self, point: ArrayLike) -> Array:
        """Give the covariance (3, 3), mm^2, that it leaves a target point (3,) with."""
        q = np.asarray(point, dtype=np.float64) - self.centroid
        cross = np.array([[0, q[2], -q[1]], [-q[2], 0, q[0]], [q[1], -q[0], 0]])
        whole = self.covariance
        found: Array = whole[3:, 3:] + cross @ whole[:3, :3] @ cross.T
        return found

    def tre(self, point: ArrayLike) -> float:
        """Give the target registration error to be expected at a target point (3,), mm RMS.

        Fitzpatrick, West & Maurer (1998): <TRE^2> = <FLE^2> / n (1 + 1/3 sum d_k^2 / f_k^2), d
        being the point's and f the RMS distance of the n points from principal axis k.
        """
        return math.sqrt(float(np.trace(self.tre_covariance(point))))

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            "R": self.R.tolist(),
            "t_mm": self.t.tolist(),
            "fre_rms_mm": self.fre,
            "fle_rms_mm": math.sqrt(3 * self.fle_variance),
            "residuals_mm": self.residuals.tolist(),
            "centroid_mm": self.centroid.tolist(),
            "covariance": self.covariance.tolist(),
        }


def register(source: ArrayLike, target: ArrayLike) -> Registration:
    """Find the rotation and translation that take points to their counterparts.

    Least squares without scale: Kabsch (1976), Umeyama (1991).

    Parameters
    ----------
    source, target
        (n, 3) the same points in two frames, mm; n at least 3, not on a line.

    Raises
    ------
    ValueError
        Shapes differ, a number is not finite, there are too few points, or they lie on a line or
        in one place in either frame, so that the rotation is open.
    """
    a, b = (np.asarray(points, dtype=np.float64) for points in (source, target))
    if a.shape != b.shape or a.ndim != 2 or a.shape[1] != 3:
        raise ValueError(f"expected points (n, 3) twice, not {a.shape} and {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ValueError("a coordinate is not finite")
    if len(a) < 3:
        raise ValueError(f"{len(a)} points leave the rotation open: at least 3 are needed")
    for name, points in (("source", a), ("target", b)):
        _refuse_line(points, name)
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    u, s, vt = np.linalg.svd((b - centre_b).T @ (a - centre_a))
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))  # a mirror image is no rotation
    if s[1] + sign * s[2] <= FLATNESS * s[0]:
        raise ValueError("the two sets of points do not fit each other: the rotation is open")
    R = u @ np.diag([1, 1, sign]) @ vt
    t = centre_b - R @ centre_a
    _, extents, axes = np.linalg.svd(b - centre_b, full_matrices=False)
    return Registration(R, t, b - (a @ R.T + t), centre_b, axes, extents / math.sqrt(len(b)))


def _refuse_line(points: Array, name: str) -> None:
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[0] == 0 or extents[1] <= FLATNESS * extents[0]:
        raise ValueError(f"the {name} points lie on a line or in one place: the rotation is open")
