"""How well a measurement repeats: pooled standard deviation, and its share of the tolerance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.capability.interval import RESOLUTION, Interval, ends, finite, variance_interval

MULTIPLIER = 6.0
"""Standard deviations that count as the width of the error: 99.73 % of a normal population.

AIAG MSA 4th edition and Eq. 23 of Lin et al. (2020); 5.15 (99 %) was AIAG's until the 3rd.
"""

CRITERIA = (20.0, 10.0)
"""Per cent of the tolerance: Lin et al. (2020) demand less than 20; 10 is AIAG's "acceptable"."""


@dataclass(frozen=True)
class Verdict:
    """Whether a ratio is below a criterion, and whether its whole interval is on that side."""

    below_percent: float
    met: bool
    clear: bool

    def to_dict(self) -> dict[str, Any]:
        """Give plain values for JSON."""
        return {"below_percent": self.below_percent, "met": self.met, "clear": self.clear}


@dataclass(frozen=True)
class Repeatability:
    """Scatter of repeated measurements.

    Attributes
    ----------
    sigma, sigma_ci
        Standard deviation pooled over the parts, and its chi-square interval; unit of the data.
    freedom
        Degrees of freedom: measurements less parts.
    parts, measurements
        How many parts had at least two measurements, and how many these were.
    multiplier, tolerance
        k and USL - LSL; the tolerance is None if unknown.
    p_t_percent, p_t_ci_percent
        100 k sigma / (USL - LSL), Eq. 23.
    verdicts
        Against each of `CRITERIA`.
    """

    sigma: float
    sigma_ci: Interval
    freedom: int
    parts: int
    measurements: int
    multiplier: float
    tolerance: float | None
    p_t_percent: float | None
    p_t_ci_percent: Interval | None
    verdicts: tuple[Verdict, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            "sigma_mm": self.sigma,
            "sigma_ci_mm": ends(self.sigma_ci),
            "degrees_of_freedom": self.freedom,
            "parts": self.parts,
            "measurements": self.measurements,
            "multiplier": self.multiplier,
            "tolerance_mm": self.tolerance,
            "p_t_percent": self.p_t_percent,
            "p_t_ci_percent": ends(self.p_t_ci_percent),
            "verdicts": [verdict.to_dict() for verdict in self.verdicts],
        }


def assess_repeatability(
    values: ArrayLike,
    parts: Sequence[object],
    *,
    tolerance: float | None = None,
    multiplier: float = MULTIPLIER,
    level: float = 0.95,
) -> Repeatability:
    """Pool the scatter of repeated measurements of several parts.

    Parameters
    ----------
    values
        (n,) measurements.
    parts
        (n,) which part (or part by an operator) a measurement is of; numbers may be unequal, and
        parts measured once tell nothing.
    tolerance
        USL - LSL, in the unit of the values, above 0.
    multiplier
        k, above 0.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        No part was measured twice, lengths differ, or a number is not finite or not above 0.
    """
    array = finite(values, 2, "values")
    if len(parts) != len(array):
        raise ValueError(f"{len(parts)} parts do not go with {len(array)} values")
    for name, number in (("tolerance", tolerance), ("multiplier", multiplier)):
        if number is not None and not (math.isfinite(number) and number > 0):
            raise ValueError(f"{name} is {number:g}: it has to be above 0")
    groups: dict[object, list[int]] = {}
    for k, part in enumerate(parts):
        groups.setdefault(part, []).append(k)
    repeated = [array[rows] for rows in groups.values() if len(rows) > 1]
    if not repeated:
        raise ValueError("no part was measured twice")
    count = sum(map(len, repeated))
    freedom = count - len(repeated)
    variance = sum(float(((v - v.mean()) ** 2).sum()) for v in repeated) / freedom
    if variance <= (RESOLUTION * float(np.abs(array).max())) ** 2:
        variance = 0.0
    sigma_ci = variance_interval(variance, freedom, level).root()
    percent = None if tolerance is None else 100 * multiplier / tolerance
    ratio = None if percent is None else percent * math.sqrt(variance)
    ratio_ci = None if percent is None else sigma_ci.scaled(percent)
    return Repeatability(
        sigma=math.sqrt(variance),
        sigma_ci=sigma_ci,
        freedom=freedom,
        parts=len(repeated),
        measurements=count,
        multiplier=multiplier,
        tolerance=tolerance,
        p_t_percent=ratio,
        p_t_ci_percent=ratio_ci,
        verdicts=() if ratio is None or ratio_ci is None else judge(ratio, ratio_ci),
    )


def judge(percent: float, interval: Interval) -> tuple[Verdict, ...]:
    """Compare a ratio in per cent with each of `CRITERIA`."""
    return tuple(
        Verdict(
            below_percent=limit,
            met=percent < limit,
            # No scatter at all is no knowledge of it: whole pixels may hide it.
            clear=0 < interval.high < limit or interval.low >= limit,
        )
        for limit in CRITERIA
    )
