"""A number with its 99 % confidence interval, and the straight lines it comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]


Z99 = float(special.ndtri(0.995))
"""Half-width of a two-sided 99 % interval, in standard deviations."""


@dataclass(frozen=True)
class Estimate:
    """A measured value, or the reason why there is none.

    Attributes
    ----------
    value
        The estimate, or None.
    low, high
        Ends of the 99 % confidence interval, or None.
    reason
        Why the value is missing.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    reason: str | None = None

    @classmethod
    def of(cls, value: float, variance: float) -> Estimate:
        """Take a normally distributed estimate of the given variance."""
        half = Z99 * math.sqrt(max(variance, 0))
        return cls(value, value - half, value + half)

    @classmethod
    def missing(cls, reason: str) -> Estimate:
        """Say why there is no value."""
        return cls(None, reason=reason)

    @classmethod
    def root(cls, square: float, variance: float, scale: float = 1.0) -> Estimate:
        """Take the root of a normally distributed square.

        A square found below 0 counts as 0, and its interval reaches up from there: so none is
        narrower than the errors allow.
        """
        half = Z99 * math.sqrt(max(variance, 0))
        best = max(square, 0)
        value, low, high = (
            scale * math.sqrt(end) for end in (best, max(best - half, 0), best + half)
        )
        return cls(value, low, high)

    def ci99(self) -> list[float] | None:
        """Give ``[low, high]``, or None."""
        return None if self.low is None or self.high is None else [self.low, self.high]

    def covers(self, truth: float) -> bool:
        """Tell whether the interval holds the truth."""
        return self.low is not None and self.high is not None and self.low <= truth <= self.high


@dataclass(frozen=True)
class Line:
    """``y = intercept + slope x``, with the covariance (2, 2) of the two.

    `misfit` is chi^2 over its 99.9 % quantile: above 1 the points are no line at their errors,
    and the covariance has been scaled up by chi^2 per degree of freedom.
    """

    intercept: float
    slope: float
    covariance: Array
    misfit: float


def fit_line(x: Array, y: Array, variance: Array) -> Line:
    """Fit a line by weighted least squares, the variance of each y being known.

    Parameters
    ----------
    x, y, variance
        (n,) with at least two different x.
    """
    weight = 1 / variance
    total = weight.sum()
    centre = (weight * x).sum() / total
    spread = (weight * (x - centre) ** 2).sum()
    slope = (weight * (x - centre) * y).sum() / spread
    level = (weight * y).sum() / total
    residual = y - level - slope * (x - centre)
    chi2, freedom = float((weight * residual**2).sum()), len(x) - 2
    misfit = chi2 / (2 * float(special.gammaincinv(freedom / 2, 0.999))) if freedom else 0.0
    inflation = chi2 / freedom if misfit > 1 else 1.0
    cross = -centre / spread
    covariance = np.array([[1 / total + centre**2 / spread, cross], [cross, 1 / spread]])
    return Line(
        float(level - slope * centre), float(slope), covariance * float(inflation), float(misfit)
    )
