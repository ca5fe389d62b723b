"""Gauge repeatability and reproducibility by analysis of variance, crossed two-way, random.

AIAG Measurement Systems Analysis, 4th edition (2010), chapter III and appendix A; intervals by
MLS (Burdick, Borror & Montgomery 2005).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike
from scipy import stats

from simtip.capability.gauge_design import balanced
from simtip.capability.interval import RESOLUTION, Array, Interval
from simtip.capability.mean_squares import (
    MeanSquare,
    difference_interval,
    ratio_interval,
    sum_interval,
)

POOL_ABOVE = 0.25
"""An interaction whose p value is above this goes into repeatability (AIAG MSA, 4th edition)."""


@dataclass(frozen=True)
class Row:
    """One line of the table: sum of squares, degrees of freedom, F against `against`, and p."""

    source: str
    ss: float
    freedom: int
    f: float | None = None
    p: float | None = None
    against: str | None = None

    @property
    def square(self) -> MeanSquare:
        """The mean square."""
        return MeanSquare(self.ss / self.freedom, self.freedom)

    def to_dict(self) -> dict[str, Any]:
        """Give plain values for JSON."""
        return {
            "source": self.source,
            "df": self.freedom,
            "ss": self.ss,
            "ms": self.square.value,
            "f": self.f,
            "p": self.p,
            "against": self.against,
        }


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


@dataclass(frozen=True)
class Anova:
    """The table as computed, whether its interaction was pooled, and the components."""

    rows: tuple[Row, ...]
    pooled: bool
    components: Components


def analyse(values: ArrayLike, level: float = 0.95, pool_above: float = POOL_ABOVE) -> Anova:
    """Split the variation of a balanced gauge study.

    Parameters
    ----------
    values
        (p, o, r) part, operator, trial; at least 2 of each, all finite.
    level
        Confidence level of the intervals.
    pool_above
        The interaction is pooled with repeatability if its p value is above this.

    Raises
    ------
    ValueError
        The shape is wrong, there are too few of something, a number is not finite, or no two
        values differ.
    """
    y = balanced(values)
    p, o, r = y.shape
    part, operator, interaction, error = _sums(y)
    f, chance = _f_test(interaction, error)
    pooled = chance is not None and chance > pool_above
    if pooled:
        rest = Row("repeatability", interaction.ss + error.ss, interaction.freedom + error.freedom)
        squares = (part.square, operator.square, rest.square)
        components = _without_interaction(squares, (p, o, r), level)
        noise = replace(rest, source="repeatability, pooled")
    else:
        kept = (part.square, operator.square, interaction.square, error.square)
        components = _with_interaction(kept, (p, o, r), level)
        noise = interaction
    rows = [_against(row, noise) for row in (part, operator)]
    rows += [replace(interaction, f=f, p=chance, against="repeatability"), error]
    total = Row("total", sum(row.ss for row in rows), y.size - 1)
    return Anova((*rows, *((noise,) if pooled else ()), total), pooled, components)


def _sums(y: Array) -> tuple[Row, Row, Row, Row]:
    p, o, r = y.shape
    grand = y.mean()
    cells, parts, operators = y.mean(axis=2), y.mean(axis=(1, 2)), y.mean(axis=(0, 2))
    both = cells - parts[:, None] - operators + grand
    rows = (
        Row("part", o * r * float(((parts - grand) ** 2).sum()), p - 1),
        Row("operator", p * r * float(((operators - grand) ** 2).sum()), o - 1),
        Row("part x operator", r * float((both**2).sum()), (p - 1) * (o - 1)),
        Row("repeatability", float(((y - cells[:, :, None]) ** 2).sum()), p * o * (r - 1)),
    )
    # What is left of a subtraction of equal numbers is rounding, and no variance.
    least = (RESOLUTION * float(abs(y).max())) ** 2
    part, operator, interaction, error = (
        row if row.square.value > least else replace(row, ss=0.0) for row in rows
    )
    return part, operator, interaction, error


def _f_test(row: Row, noise: Row) -> tuple[float | None, float | None]:
    if noise.ss == 0:
        return None, None
    f = row.square.value / noise.square.value
    return f, float(stats.f.sf(f, row.freedom, noise.freedom))


def _against(row: Row, noise: Row) -> Row:
    f, p = _f_test(row, noise)
    return replace(row, f=f, p=p, against=noise.source)


def _with_interaction(
    squares: tuple[MeanSquare, MeanSquare, MeanSquare, MeanSquare],
    shape: tuple[int, int, int],
    level: float,
) -> Components:
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


def _without_interaction(
    squares: tuple[MeanSquare, MeanSquare, MeanSquare],
    shape: tuple[int, int, int],
    level: float,
) -> Components:
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
