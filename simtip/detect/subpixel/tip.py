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
from simtip.detect.subpixel.likeness import likeness
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.picture import LEAST_COVER
from simtip.detect.subpixel.scenery import LEAN, POSE, Scenery
from simtip.detect.subpixel.tip_start import Start
from simtip.geometry import Array

COMPLEXITY = 10.0
"""Weight of the penalty for each parameter of a shape; 1 is the Bayesian information criterion's. A
freer shape scatters more, so it has to describe the picture clearly better."""

DOUBT = 0.5
"""How unsure such a comparison is, in the penalty for a parameter."""

SETTLED, HASTY_SETTLED = 0.05, 2.0
"""Change of the cost, over the misfit, at which a fit ends, and one in haste."""

VAIN = 40
"""A fit ends, too, at a step that failed and promised less than so many times that: covers of
pixels change with their borders, and the cost is no smoother."""

PATIENCE = 3.0
"""A fit goes on while so many times what its next step promises would make it the best."""

BAD_MISFIT, SLOW_GAIN = 20.0, 0.15
"""Of a fit that is not worth its steps: the misfit, and the part of the cost that one takes off."""

LEANING_MISFIT = 4.0
"""Times the shaft's or 1: a fit that is worse is no reason to let the axis lean otherwise."""

FAILED_DAMPING = 0.05
"""At least so much after a step that failed: less would try the same step again."""

MOST_STEPS, MOST_HASTY_STEPS = 25, 12

CHANCE = 1.5
"""Likeness of the ground's pixels that may be chance."""

WIDTHS = 0.7, 1.4
"""Of the shaft's width, what a tip's may be: in a picture of no needle it would go anywhere."""

LEAST_VARIANCE_PX2 = 0.0

MOST_BLUR, MOST_BLUR_PX2 = 2.0, 1.5
"""What a tip's blur may be of the shaft's, and px^2 more: of no needle it grows without end."""


@dataclass(frozen=True, eq=False)
class TipFit:
    """A fitted tip in the turned image.

    Attributes
    ----------
    family
        Which outline.
    values
        As in `simtip.detect.subpixel.scenery.POSE`, then the shape.
    covariance
        Of them.
    tip
        (2,) u, v of the apex.
    tip_covariance
        (2, 2) px^2 of it, if nothing but noise is left `unexplained`.
    found
        The outline held against the pixels.
    change
        (n, values) derivative of the picture near the needle, see `comparison.derivative`.
    likeness, wariness
        How alike what is left over is in neighbouring pixels, see
        `simtip.detect.subpixel.likeness`: as the covariance has it; and, of all pixels, as a choice
        between families has it, which had better be the simpler one.
    """

    family: Family
    values: Array
    covariance: Array
    tip: Array
    tip_covariance: Array
    found: Comparison
    change: Array
    likeness: float
    wariness: float

    @property
    def cost(self) -> float:
        """-2 log likelihood."""
        return self.found.cost

    @property
    def misfit(self) -> float:
        """Mean squared residual over the noise."""
        return self.found.misfit

    @property
    def unexplained(self) -> float:
        """By how much what is left over scatters more, in sums, than the noise."""
        return max(1.0, self.misfit) * max(1.0, self.likeness)

    @property
    def residual(self) -> Array:
        """Gray values less the fit (H W,)."""
        return self.found.residual

    def better_than(self, other: TipFit) -> bool:
        """Say whether it describes the same pixels better, for its number of parameters.

        What both leave unexplained counts as noise.
        """
        return self._worse_by(other) < 0

    def _worse_by(self, other: TipFit) -> float:
        """Give how much worse it describes the pixels, in -2 log likelihood."""
        unexplained = max(1.0, min(self.misfit, other.misfit))
        unexplained *= max(1.0, min(self.wariness, other.wariness))
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
    start: Start,
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
    start
        Where to begin.
    rival
        A fit to the same pixels. The attempt ends as soon as steps promise too little to beat it.
    hasty
        Whether to end early, and where a bad fit gets better by little: there may be better
        families.

    Returns
    -------
    fit
        None if it will hardly beat the rival.
    """
    narrow, wide = (scenery.half_px * share for share in WIDTHS)
    low = np.array([-np.inf, -np.inf, narrow, LEAST_VARIANCE_PX2, -np.inf, *family.low])
    blur = MOST_BLUR * scenery.variance_px2 + MOST_BLUR_PX2
    high = np.array([np.inf, np.inf, wide, blur, np.inf, *family.high])
    values, found = start.values, start.found
    damping = 1e-2
    fresh = False
    for _ in range(MOST_HASTY_STEPS if hasty else MOST_STEPS):
        if not fresh:
            change = derivative(scenery, family, values, found, high)
            H, g = shape_equations(scenery, values, found, change)
            fresh = True
        # What lies at a bound and would go beyond stays there.
        free = ~(((values <= low) & (g < 0)) | ((values >= high) & (g > 0)))
        free[LEAN] = found.misfit < LEANING_MISFIT * max(1.0, scenery.shaft.misfit)
        step = _step(H, g, free, damping)
        promised = float(step @ g)
        enough = (HASTY_SETTLED if hasty else SETTLED) * max(1.0, found.misfit)
        if rival is not None and _hopeless(found, values, promised, rival):
            return None
        if promised < enough:
            break
        step[:POSE] = np.clip(step[:POSE], -3, 3)
        tried = np.clip(values + step, low, high)
        there = compare(scenery, family, tried)
        gain = found.cost - there.cost
        if not gain > 0:
            damping = max(damping * 8, FAILED_DAMPING)
            if damping > 1e4 or promised < VAIN * enough:
                break
            continue
        slow = hasty and there.misfit > BAD_MISFIT and gain < SLOW_GAIN * found.cost
        change, fresh = _carried(scenery, change, found, there), False
        values, found = tried, there
        damping = max(damping / 8, 1e-5)
        if gain < enough or slow:
            break
    return _ended(scenery, family, values, found, change)


def _carried(scenery: Scenery, change: Array, found: Comparison, there: Comparison) -> Array:
    """Give a derivative near the needle for where it has moved to, by a small step."""
    everywhere = np.zeros((len(scenery.value), change.shape[1]))
    everywhere[found.near] = change
    return np.asarray(everywhere[there.near])


def _ended(
    scenery: Scenery,
    family: Family,
    values: Array,
    found: Comparison,
    change: Array,
) -> TipFit:
    """Give the fit at the end of its steps, `change` as there or some small steps before."""
    H, _ = shape_equations(scenery, values, found, change)
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
        turn @ covariance @ turn.T,
        found,
        change,
        *_likenesses(scenery, found),
    )


def _likenesses(scenery: Scenery, found: Comparison) -> tuple[float, float]:
    """Give the lesser likeness of the ground's pixels and the needle's, and of them and of all.

    Noise is alike in both; an uneven ground and a wrong idea of the needle in one of them.
    """
    over_noise = (found.residual * scenery.precision).reshape(scenery.window.shape)
    ground = (found.cover.whole < LEAST_COVER).reshape(over_noise.shape)
    beside = likeness(over_noise * ground)
    if beside < CHANCE:
        return 1.0, 1.0
    return min(beside, likeness(over_noise * ~ground)), min(beside, likeness(over_noise))


def by_tilt(scenery: Scenery, fit: TipFit) -> Array:
    """Give how the apex (2,) u, v moves with the sight's tilt, which the fit takes as known.

    A bevel seen under another tilt is fitted by another shape, the picture being the same.
    """
    family, values, found, change = fit.family, fit.values, fit.found, fit.change
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
    unexplained = max(1.0, min(found.misfit, rival.misfit)) * max(1.0, rival.wariness)
    penalty = _penalty(len(values) - len(rival.values), len(found.residual))
    ahead = (found.cost - PATIENCE * promised - rival.cost) / unexplained + penalty
    return ahead > 0


def _penalty(more: int, pixels: int) -> float:
    """Give what so many more parameters cost, of -2 log likelihood."""
    return COMPLEXITY * more * float(np.log(pixels))
