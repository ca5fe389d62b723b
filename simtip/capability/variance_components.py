"""Variance components of a crossed gauge study from its mean squares, with MLS intervals.

Burdick, Borror & Montgomery, Design and Analysis of Gauge R&R Studies (2005), chapter 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from simtip.capability.interval import Interval
from simtip.capability.mean_squares import (
    MeanSquare,
    difference_interval,
    ratio_interval,
    sum_interval,
)


@dataclass(frozen=True)
class Components:
    """Variances of the model, each with its interval or None; unit of the data, squared.

    `total` is the sum of the others; a variance that came out below 0 is 0 and named in `negative`.
    """

    repeatability: float
    operator: float
    interaction: float
    part: float
    intervals: dict[str, Interval]
    part_to_gauge: Interval
    negative: tuple[str, ...]

    @property
    def gauge(self) -> float:
        """Of one measurement of one part: repeatability, operator and interaction."""
        return self.repeatability + self.operator + self.interaction

    @property
    def total(self) -> float:
        """Of one measurement of any part."""
        return self.gauge + self.part


def with_interaction(
    squares: tuple[MeanSquare, MeanSquare, MeanSquare, MeanSquare],
    shape: tuple[int, int, int],
    level: float,
) -> Components:
    """Give the components from the mean squares of part, operator, interaction and error.

    Parameters
    ----------
    squares
        In that order.
    shape
        Numbers of parts, operators and trials.
    level
        Confidence level of the intervals.
    """
    part, operator, both, error = squares
    p, o, r = shape
    raw = {
        "part": (part.value - both.value) / (o * r),
        "operator": (operator.value - both.value) / (p * r),
        "interaction": (both.value - error.value) / r,
    }
    gauge = [(1 / (p * r), operator), ((p - 1) / (p * r), both), ((r - 1) / r, error)]
    total = [
        (1 / (o * r), part),
        (1 / (p * r), operator),
        ((p * o - p - o) / (p * o * r), both),
        ((r - 1) / r, error),
    ]
    intervals = {
        "repeatability": sum_interval([(1, error)], level),
        "operator": difference_interval(operator, both, level).scaled(1 / (p * r)),
        "interaction": difference_interval(both, error, level).scaled(1 / r),
        "part": difference_interval(part, both, level).scaled(1 / (o * r)),
        "gauge": sum_interval(gauge, level),
        "total": sum_interval(total, level),
    }
    rest = (p - 1) * both.value + p * (r - 1) * error.value
    ratio = ratio_interval(part, both, operator, rest, level).scaled(p / o)
    return _components(error.value, raw, intervals, ratio)


def without_interaction(
    squares: tuple[MeanSquare, MeanSquare, MeanSquare],
    shape: tuple[int, int, int],
    level: float,
) -> Components:
    """Give the components from the mean squares of part, operator and pooled error.

    Parameters as for `with_interaction`.
    """
    part, operator, error = squares
    p, o, r = shape
    raw = {
        "part": (part.value - error.value) / (o * r),
        "operator": (operator.value - error.value) / (p * r),
        "interaction": 0.0,
    }
    gauge = [(1 / (p * r), operator), ((p * r - 1) / (p * r), error)]
    total = [
        (1 / (o * r), part),
        (1 / (p * r), operator),
        ((p * o * r - p - o) / (p * o * r), error),
    ]
    intervals = {
        "repeatability": sum_interval([(1, error)], level),
        "operator": difference_interval(operator, error, level).scaled(1 / (p * r)),
        "part": difference_interval(part, error, level).scaled(1 / (o * r)),
        "gauge": sum_interval(gauge, level),
        "total": sum_interval(total, level),
    }
    rest = (p * r - 1) * error.value
    ratio = ratio_interval(part, error, operator, rest, level).scaled(p / o)
    return _components(error.value, raw, intervals, ratio)


def _components(
    repeatability: float,
    raw: dict[str, float],
    intervals: dict[str, Interval],
    ratio: Interval,
) -> Components:
    found = {name: max(value, 0.0) for name, value in raw.items()}
    return Components(
        repeatability=repeatability,
        **found,
        intervals={
            name: Interval(max(interval.low, 0), max(interval.high, 0))
            for name, interval in intervals.items()
        },
        part_to_gauge=ratio,
        negative=tuple(name for name, value in raw.items() if value < 0),
    )


def percent_of_total(ratio: Interval) -> Interval:
    """Give gauge R&R in per cent of total variation from parts / gauge R&R as variances."""
    high, low = (100 / math.sqrt(1 + end) for end in (ratio.low, ratio.high))
    return Interval(low, high)
