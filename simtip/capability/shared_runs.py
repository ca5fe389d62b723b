"""Values by run and position whose runs share an error, as displacements from one start do.

A two-way layout without replication, both factors random: mean squares of runs, of positions and
of the rest. Taken for independent, such values give intervals that are far too narrow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from simtip.capability.interval import Array, Interval, tails
from simtip.capability.limits import Limits
from simtip.capability.mean_squares import MeanSquare, sum_interval
from simtip.capability.quantiles import normal, student
from simtip.capability.repeatability import Repeatability, judge

METHOD = "runs and positions random: Graybill & Wang (1980), Satterthwaite (1946), MOVER"


@dataclass(frozen=True)
class Layout:
    """Mean squares of values (runs, positions).

    Attributes
    ----------
    mean
        Of all.
    runs, positions, rest
        Their mean squares.
    """

    mean: float
    runs: MeanSquare
    positions: MeanSquare
    rest: MeanSquare

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of runs and positions."""
        return self.runs.freedom + 1, self.positions.freedom + 1

    def within_interval(self, level: float) -> Interval:
        """Give the interval of the variance within a position, pooled: between its runs."""
        count = self.shape[1]
        return sum_interval([(1 / count, self.runs), ((count - 1) / count, self.rest)], level)

    def total_interval(self, level: float) -> Interval:
        """Give the interval of the variance of all values, over their number less 1."""
        parts = (self.runs, self.positions, self.rest)
        freedom = sum(part.freedom for part in parts)
        return sum_interval([(part.freedom / freedom, part) for part in parts], level)

    def mean_interval(self, level: float) -> Interval:
        """Give the interval of the mean, rather too wide: the rest counts twice in its variance."""
        count = self.shape[0] * self.shape[1]
        both = self.runs.value + self.positions.value
        if both == 0:
            return Interval(self.mean, self.mean)
        squares = (self.runs, self.positions)
        freedom = both**2 / sum(one.value**2 / one.freedom for one in squares)
        half = student(tails(level)[1], freedom) * math.sqrt(both / count)
        return Interval(self.mean - half, self.mean + half)


def layout(values: ArrayLike) -> Layout:
    """Work out the mean squares of values (runs, positions), at least two of each.

    Raises
    ------
    ValueError
        There are fewer, or a number is not finite.
    """
    y: Array = np.asarray(values, dtype=np.float64)
    if y.ndim != 2 or min(y.shape) < 2 or not np.isfinite(y).all():
        raise ValueError(f"expected finite numbers by run and position, not an array of {y.shape}")
    r, p = y.shape
    mean = y.mean()
    by_run, by_position = y.mean(axis=1), y.mean(axis=0)
    rest = y - by_run[:, None] - by_position + mean
    return Layout(
        mean=float(mean),
        runs=MeanSquare(float(p * ((by_run - mean) ** 2).sum() / (r - 1)), r - 1),
        positions=MeanSquare(float(r * ((by_position - mean) ** 2).sum() / (p - 1)), p - 1),
        rest=MeanSquare(float((rest**2).sum() / ((r - 1) * (p - 1))), (r - 1) * (p - 1)),
    )


def limits_of(found: Limits, of: Layout, level: float, share: float = 0.95) -> Limits:
    """Give limits of agreement with the intervals of such a layout; bias and limits stay."""
    bias, spread = of.mean_interval(level), of.total_interval(level).root()
    k = normal((1 + share) / 2)

    def around(end: float, sign: int) -> Interval:
        # Zou (2013): of a sum, recovered from the intervals of its two parts.
        down, up = (spread.high, spread.low) if sign < 0 else (spread.low, spread.high)
        return Interval(
            end - math.hypot(found.bias - bias.low, k * (found.sd - down)),
            end + math.hypot(bias.high - found.bias, k * (up - found.sd)),
        )

    return replace(
        found,
        method=METHOD,
        bias_ci=bias,
        lower_ci=around(found.lower, -1),
        upper_ci=around(found.upper, 1),
    )


def repeatability_of(found: Repeatability, of: Layout, level: float) -> Repeatability:
    """Give a repeatability with the intervals of such a layout; sigma and P/T stay."""
    sigma_ci = of.within_interval(level).root()
    if found.p_t_percent is None or found.tolerance is None:
        return replace(found, sigma_ci=sigma_ci)
    ratio_ci = sigma_ci.scaled(100 * found.multiplier / found.tolerance)
    return replace(
        found,
        sigma_ci=sigma_ci,
        p_t_ci_percent=ratio_ci,
        verdicts=judge(found.p_t_percent, ratio_ci),
    )
