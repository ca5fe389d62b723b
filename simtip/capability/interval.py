"""Confidence intervals of a mean, of a standard deviation, and of what is made of several.

All are for independent normally distributed values unless they say otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.capability import quantiles

Array = NDArray[np.float64]

RESOLUTION = 1e-12
"""Differences below this share of the values are rounding, not variation."""


@dataclass(frozen=True)
class Interval:
    """A confidence interval; both ends in the unit of what it is of."""

    low: float
    high: float

    def to_list(self) -> list[float | None]:
        """Give ``[low, high]``; an end that is not finite is None, as JSON has no infinity."""
        return [end if math.isfinite(end) else None for end in (self.low, self.high)]

    def scaled(self, factor: float) -> Interval:
        """Multiply both ends by a factor above 0."""
        return Interval(self.low * factor, self.high * factor)

    def root(self) -> Interval:
        """Take the root of both ends, one below 0 counting as 0: of variances, those of the SDs."""
        return Interval(math.sqrt(max(self.low, 0)), math.sqrt(max(self.high, 0)))


def ends(interval: Interval | None) -> list[float | None] | None:
    """Give ``[low, high]`` for JSON, or None."""
    return None if interval is None else interval.to_list()


def tails(level: float) -> tuple[float, float]:
    """Give the probabilities below the two ends of a two-sided interval.

    Raises
    ------
    ValueError
        The level is not between 0 and 1.
    """
    if not 0 < level < 1:
        raise ValueError(f"a confidence level is between 0 and 1, not {level:g}")
    return (1 - level) / 2, (1 + level) / 2


def finite(values: ArrayLike, least: int, what: str) -> Array:
    """Take at least so many finite numbers (n,).

    Raises
    ------
    ValueError
        There are fewer, the array is not one-dimensional, or a number is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1 or not np.isfinite(array).all():
        raise ValueError(f"{what}: expected finite numbers in one row, not {values!r}")
    if len(array) < least:
        raise ValueError(f"{what}: needs at least {least} values, not {len(array)}")
    return array


def paired(measured: ArrayLike, reference: ArrayLike, least: int) -> tuple[Array, Array]:
    """Take at least so many pairs of finite numbers, (n,) each.

    Raises
    ------
    ValueError
        There are fewer, the two differ in length, or a number is not finite.
    """
    y, x = finite(measured, least, "measured"), finite(reference, least, "reference")
    if len(x) != len(y):
        raise ValueError(f"{len(y)} measured values do not pair with {len(x)} reference values")
    return y, x


def spread(values: Array, scale: float | None = None) -> float:
    """Give the standard deviation over n - 1; 0 if it is below the rounding of such values.

    Parameters
    ----------
    values
        (n,) with n at least 2.
    scale
        Size of the numbers that the values were computed from, if not the values themselves.
    """
    size = float(np.abs(values).max()) if scale is None else scale
    deviation = float(np.std(values, ddof=1))
    return deviation if deviation > RESOLUTION * size else 0.0


def mean_interval(mean: float, sd: float, n: int, level: float) -> Interval:
    """Give Student's t interval of a mean of n values with the standard deviation sd."""
    half = quantiles.student(tails(level)[1], n - 1) * sd / math.sqrt(n)
    return Interval(mean - half, mean + half)


def variance_interval(variance: float, freedom: float, level: float) -> Interval:
    """Give the chi-square interval of a variance with that many degrees of freedom."""
    below, above = tails(level)
    low, high = (freedom * variance / quantiles.chi_square(p, freedom) for p in (above, below))
    return Interval(low, high)


def mover(estimates: Sequence[float], intervals: Sequence[Interval]) -> Interval:
    """Give the interval of a sum of independent estimates from the interval of each.

    The method of variance estimates recovery: Zou & Donner (2008), Zou (2013). For mean squares
    with positive factors it is the modified large-sample method of Graybill & Wang (1980).
    """
    total = sum(estimates)
    pairs = list(zip(estimates, intervals, strict=True))
    below = math.sqrt(sum((value - interval.low) ** 2 for value, interval in pairs))
    above = math.sqrt(sum((interval.high - value) ** 2 for value, interval in pairs))
    return Interval(total - below, total + above)
