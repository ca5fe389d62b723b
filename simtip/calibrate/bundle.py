"""Least squares over all unknowns at once: Levenberg and Marquardt's method on the arrow.

Plain sums of squares by default: the maximum-likelihood estimate for equal normal noise. With
`robust`, Huber's weights instead, with the scale taken from the median residual, so that wrong
corners hardly pull; that is for finding them, not for the final figures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.calibrate.normal_equations import Blocks, blocks, solved
from simtip.calibrate.problem import Problem, Unknowns, linearised, residuals
from simtip.geometry import Array

MAX_STEPS = 100
"""Steps tried before giving up; from a usual start 5 to 15 are taken."""

FIRST_DAMPING, MOST_DAMPING = 1e-4, 1e9

CONVERGED, ROUGHLY = 1e-12, 1e-6
"""Relative fall of the cost below which only one more step, undamped, is taken; the latter for
robust fits, which only sort."""

HUBER = 1.345
"""Huber's constant: 95 % as efficient as least squares on normal noise, per coordinate."""

RAYLEIGH_MEDIAN = 1.1774100225154747
"""Median length of a vector of two unit normal variates: sqrt(2 ln 2)."""

SCALE_FLOOR_PX = 1e-3
"""Robust scales are not taken below this: noise-free corners would weigh by their rounding."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the adjustment ended.

    Attributes
    ----------
    at
        The values found.
    left, right
        (n, 2) px, seen less modelled.
    converged
        Whether it ended because there was no further to go.
    """

    at: Unknowns
    left: Array
    right: Array
    converged: bool


def adjust(problem: Problem, start: Unknowns, *, robust: bool = False) -> Fit:
    """Find the unknowns with the least sum of squared residuals, px^2, near the start.

    Parameters
    ----------
    problem
        Corners and model.
    start
        Where to begin; coefficients that the model does not estimate have to be zero.
    robust
        Huber's loss in place of the square.

    Raises
    ------
    numpy.linalg.LinAlgError
        The corners do not determine the unknowns.
    """
    at, damping, converged = start, FIRST_DAMPING, False
    enough = ROUGHLY if robust else CONVERGED
    equations, weights, cost = _at(problem, at, robust=robust)
    for _ in range(MAX_STEPS):
        trial = at.moved(*solved(equations, damping), problem)
        trial_cost = _cost(problem, trial, weights)
        if not trial_cost < cost:
            # at the bottom the cost cannot fall any more, only its rounding changes
            if trial_cost <= cost * (1 + CONVERGED) or damping > MOST_DAMPING:
                converged = True
                break
            damping *= 10
            continue
        converged = cost - trial_cost <= enough * cost and damping <= FIRST_DAMPING
        at, damping = trial, max(damping / 10, 1e-12)
        equations, weights, cost = _at(problem, at, robust=robust)
        if converged:
            break
    at = _polished(problem, at, equations, weights, cost)
    return Fit(at, *residuals(problem, at), converged)


def spread(*residual: Array) -> float:
    """Give the standard deviation per coordinate, px, from the median length of (n, 2) residuals.

    For normal residuals; what half of the corners do, however wrong, does not matter.
    """
    lengths = np.linalg.norm(np.concatenate(residual), axis=1)
    return float(np.median(lengths)) / RAYLEIGH_MEDIAN if len(lengths) else 0.0


def huber_weights(residual: Array, scale_px: float) -> Array:
    """Give weights (n,) of corners with residuals (n, 2): 1, falling beyond Huber's constant."""
    limit = HUBER * np.sqrt(2) * max(scale_px, SCALE_FLOOR_PX)
    lengths = np.linalg.norm(residual, axis=1)
    weights: Array = limit / np.maximum(lengths, limit)
    return weights


def _at(
    problem: Problem, at: Unknowns, *, robust: bool
) -> tuple[Blocks, tuple[Array, Array] | None, float]:
    rows = linearised(problem, at)
    left, right = rows[0].residual, rows[1].residual
    weights = None
    if robust:
        scale = spread(left, right)
        weights = huber_weights(left, scale), huber_weights(right, scale)
    equations = blocks(problem, rows, weights)
    return equations, weights, float(equations.cost.sum())


def _cost(problem: Problem, at: Unknowns, weights: tuple[Array, Array] | None) -> float:
    with np.errstate(all="ignore"):
        squares = [(r * r).sum(axis=1) for r in residuals(problem, at)]
    if weights is not None:
        squares = [w * s for w, s in zip(weights, squares, strict=True)]
    cost = float(sum(s.sum() for s in squares))
    return cost if np.isfinite(cost) else np.inf


def _polished(
    problem: Problem,
    at: Unknowns,
    equations: Blocks,
    weights: tuple[Array, Array] | None,
    cost: float,
) -> Unknowns:
    """Take one full step more: the cost is flat, so its rounding stops short of the minimum."""
    last = at.moved(*solved(equations, 0.0), problem)
    return last if _cost(problem, last, weights) <= cost * (1 + 1e-9) + 1e-18 else at
