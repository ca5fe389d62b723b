"""Fit a tip's outline to the picture: where the needle ends, and its shape.

All pixels around the tip are compared with a picture of the outline. Brightness is linear and
eliminated; the place along the axis, a shift across it, the width and the shape are found by
Levenberg and Marquardt's method, with the shaft's fit as prior. Of several families of tips the one
that describes the picture best for its number of parameters is taken.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.detect.subpixel.comparison import (
    TILT_STEP,
    Comparison,
    compare,
    derivative,
    derivative_by_tilt,
    shape_equations,
)
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.scenery import POSE, Scenery
from simtip.geometry import Array

SLOPE_LEVER = 0.3

COMPLEXITY = 10.0
"""Weight of the penalty for each parameter of a shape; 1 is the Bayesian information criterion's. A
freer shape scatters more, so it has to describe the picture clearly better."""

DOUBT = 0.5
"""How unsure such a comparison is, in the penalty for a parameter."""

SETTLED = 0.05
"""Change of the cost, over the misfit, at which a fit ends."""

PATIENCE = 3.0
"""A fit goes on while so many times what its next step promises would make it the best."""

BAD_MISFIT, SLOW_GAIN = 20.0, 0.15
"""Of a fit that is not worth its steps: the misfit, and the part of the cost that one takes off."""

FAILED_DAMPING = 0.05
"""At least so much after a step that failed: less would try the same step again."""

USUALLY_AHEAD_PX, ELSE_AHEAD_PX = 2.5, (0.0, 5.0)
"""How far beyond the last row that shows the needle its end is, and else may be: rows fall short of
it."""

MOST_STEPS = 25

LEAST_VARIANCE_PX2 = 0.003

BEVELS = {"bevel", "bevel_away"}
ROUNDED = 0.1
"""Of a cone's end, half widths, to see whether a round one fits better."""


@dataclass(frozen=True, eq=False)
class TipFit:
    """A fitted tip in the turned image.

    Attributes
    ----------
    family
        Which outline.
    values
        Row of the foremost point's z on the axis, shift across, half width, shape.
    covariance
        Of them.
    tip
        (2,) u, v of the apex.
    tip_covariance
        (2, 2) px^2 of it.
    cost
        -2 log likelihood.
    misfit
        Mean squared residual over the noise.
    residual
        (H W,) gray values less the fit.
    """

    family: Family
    values: Array
    covariance: Array
    tip: Array
    tip_covariance: Array
    cost: float
    misfit: float
    residual: Array

    def better_than(self, other: TipFit) -> bool:
        """Say whether it describes the same pixels better, for its number of parameters.

        What both leave unexplained counts as noise.
        """
        return self._worse_by(other) < 0

    def _worse_by(self, other: TipFit) -> float:
        """Give how much worse it describes the pixels, in -2 log likelihood."""
        unexplained = max(1.0, min(self.misfit, other.misfit))
        penalty = _penalty(len(self.values) - len(other.values), len(self.residual))
        return (self.cost - other.cost) / unexplained + penalty

    def or_nearly(self, other: TipFit) -> TipFit:
        """Give itself, with a tip between both fits' as far as the other is nearly as good.

        A choice between two families that are about as good would else be the noise's, and what
        they differ by would be in no covariance (Hoeting et al., Bayesian Model Averaging, 1999).
        """
        doubt = DOUBT * _penalty(1, len(self.residual))
        share = float(scipy.special.expit((self._worse_by(other)) / doubt))
        apart = other.tip - self.tip
        covariance = (1 - share) * self.tip_covariance + share * other.tip_covariance
        return replace(
            self,
            tip=self.tip + share * apart,
            tip_covariance=covariance + share * (1 - share) * np.outer(apart, apart),
        )


def fit_tip(
    scenery: Scenery,
    family: Family,
    starts: list[Array],
    rival: TipFit | None = None,
    *,
    hasty: bool = False,
) -> TipFit | None:
    """Fit one family.

    Parameters
    ----------
    scenery
        The pixels and the shaft.
    family
        The outline.
    starts
        Values to begin with: from those that fit best. One at least.
    rival
        A fit to the same pixels. The attempt ends as soon as steps promise too little to beat it.
    hasty
        Whether to end, too, where a bad fit gets better by little: there may be better families.

    Returns
    -------
    fit
        None if it will hardly beat the rival.
    """
    low = np.array([-np.inf, -np.inf, 0.5, LEAST_VARIANCE_PX2, *family.low])
    high = np.array([*[np.inf] * POSE, *family.high])
    values, found = _best_start(scenery, family, starts)
    damping = 1e-2
    fresh = False
    for _ in range(MOST_STEPS):
        if not fresh:
            change = derivative(scenery, family, values, found, high)
            H, g = shape_equations(scenery, values, found, change)
            fresh = True
        # What lies at a bound and would go beyond stays there.
        free = ~(((values <= low) & (g < 0)) | ((values >= high) & (g > 0)))
        step = _step(H, g, free, damping)
        promised = float(step @ g)
        enough = SETTLED * max(1.0, found.misfit)
        if rival is not None and _hopeless(found, values, promised, rival):
            return None
        if promised < enough:
            break
        step[:POSE] = np.clip(step[:POSE], -3, 3)
        tried = np.clip(values + step, low, high)
        there = compare(scenery, family, tried)
        if not there.cost < found.cost:
            damping = max(damping * 8, FAILED_DAMPING)
            if damping > 1e4:
                break
            continue
        gain = found.cost - there.cost
        slow = hasty and there.misfit > BAD_MISFIT and gain < SLOW_GAIN * found.cost
        settled = gain < enough
        values, found, fresh = tried, there, False
        damping = max(damping / 8, 1e-5)
        if settled or slow:
            break
    return _ended(scenery, family, values, found, H)


def _ended(scenery: Scenery, family: Family, values: Array, found: Comparison, H: Array) -> TipFit:
    """Give the fit at the end of its steps, H its normal matrix there or one small step before."""
    inside = np.array(
        [True] * POSE
        + [
            low + 1e-9 < value < high - 1e-9
            for value, low, high in zip(values[POSE:], family.low, family.high, strict=True)
        ]
    )
    covariance = np.zeros_like(H)
    covariance[np.ix_(inside, inside)] = np.linalg.inv(H[np.ix_(inside, inside)])
    tip = scenery.apex(family, values)
    turn = _apex_by_values(scenery, family, values)
    return TipFit(
        family,
        values,
        covariance,
        tip,
        turn @ covariance @ turn.T + _of_slope(scenery),
        found.cost,
        found.misfit,
        found.residual,
    )


def by_tilt(scenery: Scenery, fit: TipFit) -> Array:
    """Give how the apex (2,) u, v moves with the sight's tilt, which the fit takes as known.

    A bevel seen under another tilt is fitted by another shape, the picture being the same.
    """
    family, values = fit.family, fit.values
    high = np.array([*[np.inf] * POSE, *family.high])
    found = compare(scenery, family, values)
    change = derivative(scenery, family, values, found, high)
    H, _ = shape_equations(scenery, values, found, change)
    tilting = derivative_by_tilt(scenery, family, values, found)
    known = np.linalg.solve(found.normal, found.columns.T @ tilting)
    g = change.T @ tilting - (found.columns.T @ change).T @ known
    values_by_tilt = -np.linalg.solve(H, g)
    apex = scenery.apex(family, values)
    bare = (scenery.tilted(TILT_STEP).apex(family, values) - apex) / TILT_STEP
    return np.asarray(bare + _apex_by_values(scenery, family, values) @ values_by_tilt)


def _apex_by_values(scenery: Scenery, family: Family, values: Array) -> Array:
    """Give the apex' derivative by the values, (2, n)."""
    tip = scenery.apex(family, values)
    turn = np.zeros((2, len(values)))
    for k in range(len(values)):
        moved = values.copy()
        moved[k] += 1e-4
        turn[:, k] = (scenery.apex(family, moved) - tip) / 1e-4
    return turn


def _step(H: Array, g: Array, free: NDArray[np.bool_], damping: float) -> Array:
    step = np.zeros(len(g))
    some = H[np.ix_(free, free)]
    step[free] = np.linalg.solve(some + damping * np.diag(np.diag(some)), g[free])
    return step


def _hopeless(found: Comparison, values: Array, promised: float, rival: TipFit) -> bool:
    """Say whether a fit that steps promise to improve so much will hardly beat its rival."""
    unexplained = max(1.0, min(found.misfit, rival.misfit))
    penalty = _penalty(len(values) - len(rival.values), len(found.residual))
    ahead = (found.cost - PATIENCE * promised - rival.cost) / unexplained + penalty
    return ahead > 0


def _penalty(more: int, pixels: int) -> float:
    """Give what so many more parameters cost, of -2 log likelihood."""
    return COMPLEXITY * more * float(np.log(pixels))


def _of_slope(scenery: Scenery) -> Array:
    """Give what the axis' uncertain slope, which the fit takes as known, adds to the covariance.

    The tip is held by its flanks; it moves across by a third of their length times the slope.
    """
    lever = scenery.window.height * SLOPE_LEVER
    v = np.array(float(scenery.window.v + scenery.window.height))
    slope = float(scenery.shaft.slope(v))
    across = np.array([1.0, -slope]) / np.hypot(1, slope)
    return np.asarray((lever * scenery.slope_deviation) ** 2 * np.outer(across, across))


def usual_starts(
    scenery: Scenery, family: Family, v_end: float, begin: Array, *, few: bool
) -> list[Array]:
    """Give values to begin with: shapes, and for the best of them some places of the end.

    Parameters
    ----------
    scenery
        The pixels and the shaft.
    family
        The outline.
    v_end
        The last row that shows the needle.
    begin
        What the edges suggest, see `simtip.detect.subpixel.start`.
    few
        Whether shapes are enough.
    """
    starts = [
        np.array([v_end + USUALLY_AHEAD_PX, 0.0, scenery.half_px, scenery.variance_px2, *shape])
        for shape in family.starts(begin)
    ]
    if few:
        return starts
    best, _ = _best_start(scenery, family, starts)
    return [best, *(np.array([v_end + ahead, *best[1:]]) for ahead in ELSE_AHEAD_PX)]


def like(family: Family, other: TipFit | None) -> list[Array]:
    """Give the values, none or one, at which a family looks as another's fit does."""
    if other is None:
        return []
    pose, shape = other.values[:POSE], other.values[POSE:]
    name = other.family.name
    if len(shape) == len(family.low) and (name == family.name or {name, family.name} == BEVELS):
        return [other.values]
    if name == "cone" and family.name == "wedge":
        return [np.array([*pose, 0.0, shape[0], shape[0]])]
    if name == "wedge" and family.name == "cone":
        return [np.array([*pose, (shape[1] + shape[2]) / 2])]
    if name == "cone" and family.name == "round":
        return [np.array([*pose, shape[0], ROUNDED])]
    return []


def _best_start(scenery: Scenery, family: Family, starts: list[Array]) -> tuple[Array, Comparison]:
    compared = [compare(scenery, family, values) for values in starts]
    best = int(np.argmin([one.cost for one in compared]))
    return starts[best], compared[best]
