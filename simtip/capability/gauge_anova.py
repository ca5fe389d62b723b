"""Gauge repeatability and reproducibility by analysis of variance, crossed two-way, random.

AIAG Measurement Systems Analysis, 4th edition (2010), chapter III and appendix A; intervals by
MLS (Burdick, Borror & Montgomery 2005).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike
from scipy import stats

from simtip.capability.gauge_design import balanced
from simtip.capability.interval import RESOLUTION, Array
from simtip.capability.mean_squares import MeanSquare
from simtip.capability.variance_components import (
    Components,
    with_interaction,
    without_interaction,
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
        components = without_interaction(squares, (p, o, r), level)
        noise = replace(rest, source="repeatability, pooled")
    else:
        kept = (part.square, operator.square, interaction.square, error.square)
        components = with_interaction(kept, (p, o, r), level)
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
