"""Intervals of variances that are sums and differences of mean squares.

The modified large-sample method (MLS) as Burdick, Borror & Montgomery give it for gauge studies
(Design and Analysis of Gauge R&R Studies, 2005, chapter 3): Graybill & Wang (1980) for sums, Ting
et al. (1990) for differences, Gui et al. (1995) for the ratio.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simtip.capability import quantiles
from simtip.capability.interval import Interval, mover, tails, variance_interval


@dataclass(frozen=True)
class MeanSquare:
    """A mean square of an analysis of variance, and its degrees of freedom."""

    value: float
    freedom: int


def sum_interval(terms: Sequence[tuple[float, MeanSquare]], level: float) -> Interval:
    """Give the interval of sum c MS; all factors c at least 0."""
    used = [(factor, square) for factor, square in terms if factor > 0]
    values = [factor * square.value for factor, square in used]
    squares = [
        variance_interval(value, square.freedom, level)
        for value, (_, square) in zip(values, used, strict=True)
    ]
    return mover(values, squares)


def difference_interval(large: MeanSquare, small: MeanSquare, level: float) -> Interval:
    """Give the interval of E(large) - E(small), the ends not cut off at 0."""
    a, b = large.value, small.value
    low_p, high_p = tails(level)
    G1, H1 = _spans(large.freedom, level)
    G2, H2 = _spans(small.freedom, level)
    F = quantiles.fisher(high_p, large.freedom, small.freedom)
    cross = ((F - 1) ** 2 - (G1 * F) ** 2 - H2**2) / F
    below = (G1 * a) ** 2 + (H2 * b) ** 2 + cross * a * b
    F = quantiles.fisher(low_p, large.freedom, small.freedom)
    cross = ((1 - F) ** 2 - (H1 * F) ** 2 - G2**2) / F
    above = (H1 * a) ** 2 + (G2 * b) ** 2 + cross * a * b
    return Interval(a - b - math.sqrt(max(below, 0)), a - b + math.sqrt(max(above, 0)))


def _spans(freedom: int, level: float) -> tuple[float, float]:
    """Give G and H: a mean square S has the interval (1 - G) S .. (1 + H) S."""
    interval = variance_interval(1, freedom, level)
    return 1 - interval.low, interval.high - 1


def ratio_interval(
    large: MeanSquare,
    small: MeanSquare,
    other: MeanSquare,
    rest: float,
    level: float,
) -> Interval:
    """Give the interval of (E(large) - E(small)) / (E(other) + E(rest)), not below 0.

    Parameters
    ----------
    large, small
        Mean squares whose difference is above the line: of parts, and what it is tested against.
    other
        Mean square of operators, below the line.
    rest
        The sum of factor times mean square of what else is below the line, its many degrees of
        freedom taken as knowing it.
    """
    low_p, high_p = tails(level)
    G, H = _spans(large.freedom, level)

    def end(p: float, span: float) -> float:
        above = large.value - small.value * quantiles.fisher(p, large.freedom, small.freedom)
        below = rest + span * other.value * quantiles.fisher(p, large.freedom, other.freedom)
        if below == 0:
            return math.inf if above > 0 else 0.0
        return max(span * above / below, 0)

    return Interval(end(high_p, 1 - G), end(low_p, 1 + H))
