"""The square root of the shared unknowns' normal matrix, without ever forming its square.

The poses are eliminated view by view by orthogonal transforms, which lose half the digits that the
normal equations lose: a rational lens model needs them.
"""

from __future__ import annotations

import numpy as np

from simtip.calibrate.problem import POSE, Problem, Rows
from simtip.geometry import Array

SINGULAR = 1e-13
"""A diagonal entry of the root below this, of columns of unit length, is only rounding."""

BLOCK = 4
"""Rows of a block, in columns."""


def shared_covariance(problem: Problem, rows: tuple[Rows, Rows]) -> Array:
    """Give the (s, s) covariance of the shared unknowns for corner noise of 1 px.

    Raises
    ------
    numpy.linalg.LinAlgError
        The corners do not determine the unknowns.
    """
    s, free = problem.shared, len(problem.model.free)
    sides = problem.left.slices(problem.views), problem.right.slices(problem.views)
    parts = []
    for of_left, of_right in zip(*sides, strict=True):
        left = _table(rows[0], of_left, s, slice(POSE, POSE + free))
        right = _table(rows[1], of_right, s, slice(POSE + free, POSE + s))
        parts.append(_triangle(np.concatenate([left, right]))[POSE:, POSE:])
    stacked = np.concatenate(parts)
    scale = np.linalg.norm(stacked, axis=0)
    if not (np.isfinite(scale).all() and (scale > 0).all()):
        raise np.linalg.LinAlgError("an unknown has no influence on any pixel")
    root = _triangle(stacked / scale)
    if len(root) < s or np.abs(np.diagonal(root)).min() < SINGULAR:
        raise np.linalg.LinAlgError("the unknowns cannot be told apart")
    inverse = np.linalg.inv(root) / scale[:, None]
    covariance: Array = inverse @ inverse.T
    return covariance


def _triangle(matrix: Array) -> Array:
    """Give the R of a QR factorisation, by blocks of rows, which are quicker than a tall matrix."""
    columns = matrix.shape[1]
    block = BLOCK * columns
    while len(matrix) > block:
        missing = -len(matrix) % block
        padded = np.concatenate([matrix, np.zeros((missing, columns))])
        factors = np.linalg.qr(padded.reshape(-1, block, columns)).R
        matrix = factors.reshape(-1, columns)
    return np.linalg.qr(matrix).R


def _table(rows: Rows, part: slice, shared: int, columns: slice) -> Array:
    """Put one camera's rows of one view into columns: the pose, then all that is shared."""
    residuals = 2 * (part.stop - part.start)
    table = np.zeros((residuals, POSE + shared))
    table[:, :POSE] = rows.board[part].reshape(residuals, POSE)
    own = np.concatenate([rows.camera[part], rows.relative[part]], axis=2)
    if residuals:
        table[:, columns] = own.reshape(residuals, own.shape[2])
    return table
