"""How far off the estimates may be: covariances from the residuals.

``sigma^2 (J^T J)^-1`` with ``sigma^2 = sum of squared residuals / degrees of freedom``, to first
order. It holds for corner errors that are independent, without bias and equal in size, for the
distortion model given; a bent board or a wrong square size is beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.calibrate.bundle import Fit
from simtip.calibrate.normal_equations import blocks, inverse
from simtip.calibrate.problem import Problem, linearised
from simtip.calibrate.square_root import shared_covariance
from simtip.geometry import Array, skew, unit

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")

RELATIVE = ("rotation_x", "rotation_y", "rotation_z", "T_x", "T_y", "T_z")


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariances of all that was estimated.

    Attributes
    ----------
    sigma_px
        Standard deviation of a corner's u or v, px, from the residuals.
    degrees_of_freedom
        Coordinates less unknowns.
    names
        (s,) of the shared unknowns: ``left.fx`` ... ``T_z``, px, rad, mm. The rotation is a small
        one after R, about the axes of the left camera.
    covariance
        (s, s) of the shared unknowns.
    pose_covariances
        (views, 6, 6) of each board's pose in the left camera: small rotation about the left
        camera's axes, rad, then translation, mm.
    """

    sigma_px: float
    degrees_of_freedom: int
    names: tuple[str, ...]
    covariance: Array
    pose_covariances: Array

    def std(self, name: str) -> float:
        """Give the standard deviation of a shared unknown."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    def block(self, names: tuple[str, ...]) -> Array:
        """Give the covariance (n, n) of some of the shared unknowns."""
        where = [self.names.index(name) for name in names]
        return self.covariance[np.ix_(where, where)]


def uncertainty_of(problem: Problem, fit: Fit) -> Uncertainty:
    """Propagate the residuals of a plain least-squares fit into its unknowns.

    Raises
    ------
    numpy.linalg.LinAlgError
        The corners do not determine the unknowns.
    """
    freedom = problem.degrees_of_freedom
    if freedom < 1:
        raise np.linalg.LinAlgError("more unknowns than coordinates")
    rows = linearised(problem, fit.at)
    equations = blocks(problem, rows)
    variance = float(equations.cost.sum()) / freedom
    shared = shared_covariance(problem, rows)
    V_inverse = inverse(equations.V)
    carried = V_inverse @ np.swapaxes(equations.W, 1, 2)
    poses = V_inverse + carried @ shared @ np.swapaxes(carried, 1, 2)
    return Uncertainty(
        sigma_px=float(np.sqrt(variance)),
        degrees_of_freedom=freedom,
        names=_names(problem),
        covariance=variance * shared,
        pose_covariances=variance * poses,
    )


def _names(problem: Problem) -> tuple[str, ...]:
    free = [INTRINSICS[i] for i in problem.model.free]
    left = tuple(f"left.{name}" for name in free)
    if not problem.stereo:
        return left
    return left + tuple(f"right.{name}" for name in free) + RELATIVE


@dataclass(frozen=True, eq=False)
class Deviations:
    """Standard deviations, in the shapes of what they belong to; 0 where nothing was estimated.

    Attributes
    ----------
    K_left, K_right
        (3, 3) px.
    D_left, D_right
        As many as there are coefficients.
    R
        (3, 3), entry by entry.
    rotation_deg
        (3,) of the small rotation about the left camera's x, y and z axes, degrees.
    T_mm
        (3,) mm.
    baseline_mm
        Of the length of T, mm.
    """

    K_left: Array
    D_left: Array
    K_right: Array
    D_right: Array
    R: Array
    rotation_deg: Array
    T_mm: Array
    baseline_mm: float


def deviations(uncertainty: Uncertainty, problem: Problem, fit: Fit) -> Deviations:
    """Read the standard deviations of a stereo calibration off its covariance."""
    turn, shift = uncertainty.block(RELATIVE[:3]), uncertainty.block(RELATIVE[3:])
    along = unit(fit.at.T)
    # R turned by w changes by [w]x R: column k of the table is what w_k does to the entries
    entries = np.stack([(skew(axis) @ fit.at.R).ravel() for axis in np.eye(3)], axis=1)
    return Deviations(
        K_left=_std_of_matrix(uncertainty, "left"),
        D_left=_std_of_coefficients(uncertainty, "left", problem),
        K_right=_std_of_matrix(uncertainty, "right"),
        D_right=_std_of_coefficients(uncertainty, "right", problem),
        R=_root(np.einsum("ni,ij,nj->n", entries, turn, entries)).reshape(3, 3),
        rotation_deg=np.degrees(_root(np.diagonal(turn))),
        T_mm=_root(np.diagonal(shift)),
        baseline_mm=float(_root(along @ shift @ along)),
    )


def _root(variances: Array) -> Array:
    # rounding may leave the variance of a fixed entry a hair below zero
    root: Array = np.sqrt(np.maximum(variances, 0.0))
    return root


def _std_of_matrix(uncertainty: Uncertainty, camera: str) -> Array:
    fx, fy, cx, cy = (uncertainty.std(f"{camera}.{name}") for name in INTRINSICS[:4])
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 0.0]])


def _std_of_coefficients(uncertainty: Uncertainty, camera: str, problem: Problem) -> Array:
    std = np.zeros(len(INTRINSICS))
    for i in problem.model.free[4:]:
        std[i] = uncertainty.std(f"{camera}.{INTRINSICS[i]}")
    return std[4 : 4 + problem.model.coefficients]
