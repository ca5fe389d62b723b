"""The fundamental matrix from pairs of points, and how far pairs are from it.

Order and sign: the paper's, ``p_l^T F p_r = 0`` (Eq. 12), scaled to unit Frobenius norm with
F33 above 0 (its largest entry, where F33 vanishes). `as_printed` scales to F33 = 1 as Eq. 16 does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array
from simtip.match import distance_to_line, epipolar_lines

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)

BINS = 20
"""Bars of the histogram, from 0 to the largest distance."""

MIN_PAIRS = 8

VANISHING = 1e-12
"""F33 below this, of unit norm, is 0: the cameras look along parallel axes."""


def eight_point(left_px: ArrayLike, right_px: ArrayLike) -> Array:
    """Estimate F by the normalised eight-point method from all pairs (Hartley 1997).

    Each side is moved to its centroid and scaled to a root-mean-square distance of sqrt(2); the
    singular vector of the least singular value minimises the sum of squares of ``p_l^T F p_r``;
    the least singular value of F itself is then set to zero.

    Parameters
    ----------
    left_px, right_px
        (n, 2) paired points, n at least 8; of lenses with distortion, undistorted px.

    Returns
    -------
    Array
        (3, 3), rank 2; order and scale as in the module.

    Raises
    ------
    ValueError
        There are fewer than eight pairs, or they are not pairs of finite points.
    """
    left, right = (np.asarray(p, dtype=np.float64) for p in (left_px, right_px))
    if left.shape != right.shape or left.ndim != 2 or left.shape[1] != 2:
        raise ValueError("pairs are two arrays (n, 2) of the same length")
    if len(left) < MIN_PAIRS:
        raise ValueError(f"F takes at least {MIN_PAIRS} pairs, not {len(left)}")
    if not (np.isfinite(left).all() and np.isfinite(right).all()):
        raise ValueError("a point is not finite")
    N_l, N_r = _normalising(left), _normalising(right)
    p, q = _homogeneous(left) @ N_l.T, _homogeneous(right) @ N_r.T
    rows = (p[:, :, None] * q[:, None, :]).reshape(-1, 9)
    # the R of a QR factorisation has the same singular vectors and nine rows
    triangle = np.linalg.qr(rows).R
    F = np.linalg.svd(triangle)[2][-1].reshape(3, 3)
    u, s, vt = np.linalg.svd(F)
    return scaled(N_l.T @ (u @ np.diag([s[0], s[1], 0.0]) @ vt) @ N_r)


def scaled(F: ArrayLike) -> Array:
    """Scale F (3, 3) to unit Frobenius norm and give it the module's sign."""
    matrix = np.asarray(F, dtype=np.float64)
    unit: Array = matrix / np.linalg.norm(matrix)
    leading = unit[2, 2] if abs(unit[2, 2]) > VANISHING else unit.flat[np.abs(unit).argmax()]
    return unit if leading > 0 else -unit


def as_printed(F: ArrayLike) -> Array:
    """Scale F (3, 3) to F33 = 1, as the paper's Eq. 16 has it.

    Raises
    ------
    ValueError
        F33 is 0.
    """
    matrix = scaled(F)
    if abs(matrix[2, 2]) <= VANISHING:
        raise ValueError("F33 is 0 and cannot be scaled to 1")
    printed: Array = matrix / matrix[2, 2]
    return printed


def _normalising(points: Array) -> Array:
    centre = points.mean(axis=0)
    size = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
    if size == 0:
        raise ValueError("all points are the same")
    s = np.sqrt(2) / size
    return np.array([[s, 0, -s * centre[0]], [0, s, -s * centre[1]], [0, 0, 1]])


def _homogeneous(points: Array) -> Array:
    return np.column_stack([points, np.ones(len(points))])


@dataclass(frozen=True, eq=False)
class EpipolarDistances:
    """Distances of pairs from each other's epipolar lines.

    Attributes
    ----------
    F
        (3, 3) the matrix they are judged by.
    left_px, right_px
        (n,) px, at least 0, of the left point to the line ``F p_r`` and of the right point to the
        line ``F^T p_l``: the latter is the paper's Eq. 17.
    """

    F: Array
    left_px: Array
    right_px: Array

    @property
    def symmetric_px(self) -> Array:
        """(n,) the mean of the two, as `simtip.match` judges tips."""
        both: Array = (self.left_px + self.right_px) / 2
        return both

    def summary(self) -> dict[str, object]:
        """Give mean, max and distribution: of Eq. 17, and below ``symmetric`` of both views."""
        return {**_distribution(self.right_px), "symmetric": _distribution(self.symmetric_px)}


def epipolar_of(left_px: ArrayLike, right_px: ArrayLike, F: ArrayLike) -> EpipolarDistances:
    """Measure the distances of pairs (n, 2) of points under F, in the paper's order."""
    matrix = np.asarray(F, dtype=np.float64)
    return EpipolarDistances(
        F=matrix,
        left_px=distance_to_line(left_px, epipolar_lines(right_px, matrix)),
        right_px=distance_to_line(right_px, epipolar_lines(left_px, matrix.T)),
    )


def _distribution(distances: Array) -> dict[str, object]:
    counts, edges = np.histogram(distances, bins=BINS, range=(0.0, float(distances.max())))
    quantiles = np.quantile(distances, QUANTILES)
    return {
        "mean": float(distances.mean()),
        "max": float(distances.max()),
        "rms": float(np.sqrt((distances**2).mean())),
        "quantiles": {f"{q:g}": float(x) for q, x in zip(QUANTILES, quantiles, strict=True)},
        "histogram": {"edges": edges.tolist(), "counts": counts.tolist()},
    }
