"""A straight line by least squares, and the correlation, with intervals and p values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from simtip.capability import quantiles
from simtip.capability.interval import Array, Interval, ends, paired, spread, tails


@dataclass(frozen=True)
class Regression:
    """``y = intercept + slope x`` by ordinary least squares.

    Attributes
    ----------
    slope, intercept
        The line; the slope is in units of y per unit of x.
    slope_ci, intercept_ci
        Student's t intervals; None if the points lie on the line or there are only two.
    slope_p, intercept_p
        Of slope, and intercept, being 0, two-sided; None likewise.
    """

    slope: float
    slope_ci: Interval | None
    slope_p: float | None
    intercept: float
    intercept_ci: Interval | None
    intercept_p: float | None

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            "slope": self.slope,
            "slope_ci": ends(self.slope_ci),
            "slope_p": self.slope_p,
            "intercept_mm": self.intercept,
            "intercept_ci_mm": ends(self.intercept_ci),
            "intercept_p": self.intercept_p,
        }


def regress(y: ArrayLike, x: ArrayLike, level: float = 0.95) -> Regression | None:
    """Fit a straight line to points (n,); None if all x are equal.

    Raises
    ------
    ValueError
        There are fewer than two points, lengths differ, or a number is not finite.
    """
    ys, xs = paired(y, x, 2)
    if spread(xs) == 0:
        return None
    n, centre = len(xs), float(xs.mean())
    width = float(((xs - centre) ** 2).sum())
    slope = float(((xs - centre) * (ys - ys.mean())).sum()) / width
    intercept = float(ys.mean()) - slope * centre
    residual = ys - intercept - slope * xs
    scale = max(float(np.abs(ys).max()), abs(slope) * float(np.abs(xs).max()))
    if n < 3 or spread(residual, scale) == 0:
        return Regression(slope, None, None, intercept, None, None)
    deviation = math.sqrt(float((residual**2).sum()) / (n - 2))
    of_slope = deviation / math.sqrt(width)
    of_intercept = deviation * math.sqrt(1 / n + centre**2 / width)
    slope_ci, slope_p = _student(slope, of_slope, n - 2, level)
    intercept_ci, intercept_p = _student(intercept, of_intercept, n - 2, level)
    return Regression(slope, slope_ci, slope_p, intercept, intercept_ci, intercept_p)


def _student(value: float, error: float, freedom: int, level: float) -> tuple[Interval, float]:
    half = quantiles.student(tails(level)[1], freedom) * error
    p = 2 * float(stats.t.sf(abs(value) / error, freedom))
    return Interval(value - half, value + half), p


def correlation(y: ArrayLike, x: ArrayLike) -> float | None:
    """Give Pearson's r of points (n,); None if either does not vary."""
    ys, xs = paired(y, x, 2)
    if spread(ys) == 0 or spread(xs) == 0:
        return None
    a, b = ys - ys.mean(), xs - xs.mean()
    r = float((a * b).sum() / math.sqrt(float((a**2).sum()) * float((b**2).sum())))
    return min(max(r, -1.0), 1.0)


def squared_correlation(y: ArrayLike, x: ArrayLike) -> float | None:
    """Give r^2, which is R^2 of the regression of y on x; None if either does not vary."""
    r = correlation(y, x)
    return None if r is None else r**2


def fisher_interval(r: float, error: float, level: float) -> Interval:
    """Give the interval of a correlation whose inverse hyperbolic tangent has that error."""
    if abs(r) == 1:
        return Interval(r, r)
    half = quantiles.normal(tails(level)[1]) * error
    return Interval(math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half))


def correlation_interval(r: float, n: int, level: float) -> Interval | None:
    """Give Fisher's interval of Pearson's r of n pairs; None below 4 pairs."""
    return fisher_interval(r, 1 / math.sqrt(n - 3), level) if n > 3 else None


def breusch_pagan(residual: Array, x: Array) -> float | None:
    """Give the p value of equal variance along x, Breusch-Pagan in Koenker's (1981) form.

    n times R^2 of the squared residuals on x, against chi-square with 1 degree of freedom. None
    if the residuals are 0, or of one size.
    """
    r2 = squared_correlation(residual**2, x)
    return None if r2 is None else float(stats.chi2.sf(len(x) * r2, 1))
