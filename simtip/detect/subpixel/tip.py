"""Fit a tip's outline to the picture: where the needle ends, and its shape.

All pixels around the tip are compared with a picture of the outline. Brightness is linear and
eliminated; the place along the axis, a shift across it, the width and the shape are found by
Levenberg and Marquardt's method, with the shaft's fit as prior. Of several families of tips the one
that describes the picture best for its number of parameters is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.subpixel.comparison import Comparison, compare, derivative, shape_equations
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.scenery import POSE, Scenery
from simtip.geometry import Array

SLOPE_LEVER = 0.2

COMPLEXITY = 3.0
"""Weight of the penalty for each parameter of a shape; 1 is the Bayesian information criterion's. A
freer shape scatters more, so it has to describe the picture clearly better."""

SETTLED = 0.05
"""Change of the cost at which a fit ends."""

AHEAD_PX = (0.0, 2.5, 5.0)
MOST_STEPS = 25


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
        unexplained = max(1.0, min(self.misfit, other.misfit))
        more = len(self.values) - len(other.values)
        penalty = COMPLEXITY * more * float(np.log(len(self.residual)))
        return (self.cost - other.cost) / unexplained + penalty < 0


def fit_tip(
    scenery: Scenery,
    family: Family,
    v_end: float,
    begin: Array,
    known: list[Array] | None = None,
) -> TipFit:
    """Fit one family from a start.

    Parameters
    ----------
    scenery
        The pixels and the shaft.
    family
        The outline.
    v_end
        The last row that shows the needle.
    begin
        What the edges suggest.
    known
        Further values to begin with, if their family has as many.
    """
    low = np.array([-np.inf, -np.inf, 0.5, *family.low])
    high = np.array([np.inf, np.inf, np.inf, *family.high])
    values, found = _best_start(scenery, family, v_end, begin, known or [])
    damping = 1e-2
    change = None
    for _ in range(MOST_STEPS):
        if change is None:
            change = derivative(scenery, family, values, found, high)
            H, g = shape_equations(scenery, values, found, change)
        step = np.linalg.solve(H + damping * np.diag(np.diag(H)), g)
        step[:POSE] = np.clip(step[:POSE], -3, 3)
        tried = np.clip(values + step, low, high)
        there = compare(scenery, family, tried)
        if not there.cost < found.cost:
            damping *= 8
            if damping > 1e4:
                break
            continue
        settled = found.cost - there.cost < SETTLED
        values, found, change = tried, there, None
        damping = max(damping / 8, 1e-5)
        if settled:
            break
    change = derivative(scenery, family, values, found, high)
    H, _ = shape_equations(scenery, values, found, change)
    free = ~((values <= low + 1e-9) | (values >= high - 1e-9))
    covariance = np.zeros_like(H)
    covariance[np.ix_(free, free)] = np.linalg.inv(H[np.ix_(free, free)])
    tip = scenery.apex(family, values)
    turn = np.zeros((2, len(values)))
    for k in range(len(values)):
        moved = values.copy()
        moved[k] += 1e-4
        turn[:, k] = (scenery.apex(family, moved) - tip) / 1e-4
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


def _of_slope(scenery: Scenery) -> Array:
    """Give what the axis' uncertain slope, which the fit takes as known, adds to the covariance.

    The tip is held by its flanks; it moves across by a third of their length times the slope.
    """
    lever = scenery.window.height * SLOPE_LEVER
    v = np.array(float(scenery.window.v + scenery.window.height))
    slope = float(scenery.shaft.slope(v))
    across = np.array([1.0, -slope]) / np.hypot(1, slope)
    return np.asarray((lever * scenery.slope_deviation) ** 2 * np.outer(across, across))


def _best_start(
    scenery: Scenery, family: Family, v_end: float, begin: Array, known: list[Array]
) -> tuple[Array, Comparison]:
    """Try starts: also further on, as the last row that shows the needle falls short of its end."""
    starts = [
        np.array([v_end + ahead, 0.0, scenery.half_px, *shape])
        for ahead in AHEAD_PX
        for shape in family.starts(begin)
    ]
    starts += [values for values in known if len(values) == POSE + len(family.low)]
    compared = [compare(scenery, family, values) for values in starts]
    best = int(np.argmin([one.cost for one in compared]))
    return starts[best], compared[best]
