"""The normal equations of the joint problem, one block per view, and what to do with them.

Views meet only in what they share (the cameras and their relative pose), so the matrix is an
arrow. With U the shared block, V_i a view's pose and W_i what couples the two, eliminating the
poses leaves ``S = sum (U_i - W_i V_i^-1 W_i^T)``, as small as the shared unknowns are many.
Triggs et al., "Bundle adjustment: a modern synthesis" (2000), section 6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.calibrate.problem import POSE, Problem, Rows
from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class Blocks:
    """J^T J and J^T r of each view.

    Attributes
    ----------
    U
        (views, s, s) of the shared unknowns.
    W
        (views, s, 6) shared by pose.
    V
        (views, 6, 6) of the pose.
    b_shared, b_pose
        (views, s) and (views, 6), J^T r.
    cost
        (views,) sum of squared residuals, px^2.
    """

    U: Array
    W: Array
    V: Array
    b_shared: Array
    b_pose: Array
    cost: Array


def blocks(
    problem: Problem, rows: tuple[Rows, Rows], weights: tuple[Array, Array] | None = None
) -> Blocks:
    """Sum up rows by view, each corner with its weight (n,), 1 by default."""
    s, free = problem.shared, len(problem.model.free)
    size = s + POSE + 1
    gram = np.zeros((problem.views, size, size))
    tail = np.arange(s, size)
    columns = (
        np.concatenate([np.arange(free), tail]),
        np.concatenate([np.arange(free, s), tail]),
    )
    for side, corners in enumerate((problem.left, problem.right)):
        if not len(corners):
            continue
        parts = rows[side]
        table = np.concatenate(
            [parts.camera, parts.relative, parts.board, parts.residual[:, :, None]], axis=2
        )
        if weights is not None:
            table = table * np.sqrt(weights[side])[:, None, None]
        into = np.ix_(columns[side], columns[side])
        for i, part in enumerate(corners.slices(problem.views)):
            A = table[part].reshape(-1, table.shape[2])
            gram[i][into] += A.T @ A
    pose = slice(s, s + POSE)
    return Blocks(
        U=gram[:, :s, :s],
        W=gram[:, :s, pose],
        V=gram[:, pose, pose],
        b_shared=gram[:, :s, -1],
        b_pose=gram[:, pose, -1],
        cost=gram[:, -1, -1],
    )


@dataclass(frozen=True, eq=False)
class Reduced:
    """Each view's part of the problem after its pose is eliminated.

    Attributes
    ----------
    S
        (views, s, s); their sum is the Schur complement.
    b
        (views, s) reduced J^T r.
    cost
        (views,) px^2, at the best pose for the shared values (to first order).
    """

    S: Array
    b: Array
    cost: Array


def reduced(equations: Blocks) -> Reduced:
    """Eliminate the poses."""
    V_inverse = inverse(equations.V)
    WV = equations.W @ V_inverse
    return Reduced(
        S=equations.U - WV @ np.swapaxes(equations.W, 1, 2),
        b=equations.b_shared - (WV @ equations.b_pose[:, :, None])[:, :, 0],
        cost=equations.cost
        - np.einsum("ni,nij,nj->n", equations.b_pose, V_inverse, equations.b_pose),
    )


def solved(equations: Blocks, damping: float) -> tuple[Array, Array]:
    """Give the step of the shared unknowns (s,) and of the poses (views, 6).

    Levenberg and Marquardt's: each diagonal entry grows by the factor 1 + damping.

    Raises
    ------
    numpy.linalg.LinAlgError
        The equations are singular.
    """
    V = equations.V * (1 + damping * np.eye(POSE))
    V_inverse = inverse(V)
    WV = equations.W @ V_inverse
    U = equations.U.sum(axis=0)
    S = U * (1 + damping * np.eye(len(U))) - np.einsum("nij,nkj->ik", WV, equations.W)
    b = equations.b_shared.sum(axis=0) - np.einsum("nij,nj->i", WV, equations.b_pose)
    scale = _scale(U)
    shared = np.linalg.solve(S * scale[:, None] * scale, b * scale) * scale
    rest = equations.b_pose - np.einsum("nij,i->nj", equations.W, shared)
    poses: Array = np.einsum("nij,nj->ni", V_inverse, rest)
    return shared, poses


def inverse(matrices: Array) -> Array:
    """Invert positive matrices (..., n, n), brought to a unit diagonal first for precision.

    Raises
    ------
    numpy.linalg.LinAlgError
        One is singular.
    """
    scale = _scale(matrices)
    both = scale[..., :, None] * scale[..., None, :]
    inverted: Array = np.linalg.inv(matrices * both) * both
    return inverted


def _scale(matrices: Array) -> Array:
    diagonal = np.diagonal(matrices, axis1=-2, axis2=-1)
    if not (np.isfinite(diagonal).all() and (diagonal > 0).all()):
        raise np.linalg.LinAlgError("an unknown has no influence on any pixel")
    scale: Array = 1 / np.sqrt(diagonal)
    return scale
