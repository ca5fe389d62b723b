"""Rigid poses. ``T_ab`` maps coordinates in b to coordinates in a, so names chain.

``p_a = T_ab.apply(p_b)`` and ``T_ac = T_ab @ T_bc``. Lengths are millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]

ROTATION_TOLERANCE = 5e-3
"""Largest entry of ``R R^T - I`` that is taken for rounding: the paper's Table 1 has 1.3e-3."""

ROTATION_ROUNDING = 1e-14
"""Entries of ``|M M^T - I|`` up to this are rounding: the product of fifty rotations has fewer."""


def nearest_rotation(matrix: ArrayLike, tolerance: float = ROTATION_TOLERANCE) -> Array:
    """Return the rotation nearest to a nearly orthonormal matrix (Frobenius norm, by SVD).

    What is a rotation to the rounding of its products is given back to the bit, so that a rig reads
    back from a file as it was.

    Parameters
    ----------
    matrix
        (3, 3), a rotation up to the rounding of its printed digits.
    tolerance
        Largest accepted entry of ``|M M^T - I|``.

    Raises
    ------
    ValueError
        The matrix is not finite, not (3, 3), mirrored, or further from a rotation.
    """
    m = np.asarray(matrix, dtype=np.float64)
    if m.shape != (3, 3):
        raise ValueError(f"a rotation is 3 x 3, not {' x '.join(map(str, m.shape))}")
    if not np.isfinite(m).all():
        raise ValueError("the rotation has an entry that is not finite")
    with np.errstate(over="ignore", invalid="ignore"):
        off = float(np.abs(m @ m.T - np.eye(3)).max())
    if not off <= tolerance:
        raise ValueError(f"not a rotation: R R^T differs from the identity by {off:.3g}")
    u, _, vt = np.linalg.svd(m)
    rotation: Array = m.copy() if off <= ROTATION_ROUNDING else u @ vt
    if np.linalg.det(rotation) < 0:
        raise ValueError("not a rotation: it mirrors (determinant -1)")
    return rotation


def unit(vector: ArrayLike) -> Array:
    """Scale vectors (..., 3) or (..., 2) to length 1."""
    v = np.asarray(vector, dtype=np.float64)
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    if not np.all(length > 0) or not np.isfinite(length).all():
        raise ValueError("a direction needs a finite length above zero")
    scaled: Array = v / length
    return scaled


def skew(vector: ArrayLike) -> Array:
    """Give the (3, 3) matrix with ``skew(a) @ b = a x b``."""
    x, y, z = np.asarray(vector, dtype=np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform ``p_a = R p_b + t``.

    Attributes
    ----------
    R
        (3, 3) rotation.
    t
        (3,) mm, the origin of b in a.
    """

    R: Array
    t: Array

    def __post_init__(self) -> None:
        t = np.array(self.t, dtype=np.float64).reshape(-1)
        if t.shape != (3,) or not np.isfinite(t).all():
            raise ValueError("a translation is three finite numbers")
        R = nearest_rotation(self.R, tolerance=1e-6)
        R.setflags(write=False)
        t.setflags(write=False)
        object.__setattr__(self, "R", R)
        object.__setattr__(self, "t", t)

    @classmethod
    def identity(cls) -> Pose:
        """Give the pose that changes nothing."""
        return cls(np.eye(3), np.zeros(3))

    def apply(self, points: ArrayLike) -> Array:
        """Map points (..., 3), mm, from b to a."""
        mapped: Array = np.asarray(points, dtype=np.float64) @ self.R.T + self.t
        return mapped

    def rotate(self, directions: ArrayLike) -> Array:
        """Map directions (..., 3) from b to a: no translation."""
        turned: Array = np.asarray(directions, dtype=np.float64) @ self.R.T
        return turned

    def matrix(self) -> Array:
        """Give the homogeneous (4, 4) matrix."""
        return np.block([[self.R, self.t[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])

    def inverse(self) -> Pose:
        """Give T_ba."""
        return Pose(self.R.T, -self.R.T @ self.t)

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.R @ other.R, self.R @ other.t + self.t)
