"""A gauge study of parts, operators and trials, as AIAG MSA (4th edition) reports it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from simtip.capability.gauge_anova import POOL_ABOVE, Anova, analyse
from simtip.capability.gauge_design import balanced
from simtip.capability.gauge_ranges import RangeStudy, distinct_categories, study_ranges
from simtip.capability.interval import Interval, ends
from simtip.capability.repeatability import MULTIPLIER
from simtip.capability.variance_components import percent_of_total

NAMES = {
    "ev": "repeatability",
    "av": "operator",
    "interaction": "interaction",
    "grr": "gauge",
    "pv": "part",
    "tv": "total",
}
"""AIAG's short names, and those of the variance components."""


@dataclass(frozen=True)
class Gauge:
    """Gauge repeatability and reproducibility.

    Attributes
    ----------
    shape
        Numbers of parts, operators and trials.
    anova
        By analysis of variance: what the figures are from.
    ranges
        The same by averages and ranges.
    multiplier, tolerance
        k of ``% of tolerance``, and USL - LSL or None.
    """

    shape: tuple[int, int, int]
    anova: Anova
    ranges: RangeStudy
    multiplier: float
    tolerance: float | None

    def sd(self, name: str) -> float:
        """Give a standard deviation by its name in `NAMES`; unit of the data."""
        return math.sqrt(float(getattr(self.anova.components, NAMES[name])))

    def sd_ci(self, name: str) -> Interval | None:
        """Give its interval, or None: a pooled interaction has none."""
        variance = self.anova.components.intervals.get(NAMES[name])
        return None if variance is None else variance.root()

    @property
    def ndc(self) -> int | None:
        """Number of distinct categories, 1.41 PV / GRR cut to a whole number, at least 1."""
        return distinct_categories(self.sd("pv"), self.sd("grr"))

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know about these figures."""
        row = next(row for row in self.anova.rows if row.source == "part x operator")
        notes = []
        if row.p is None:
            notes.append("no trial differs from another: the interaction cannot be tested")
        elif self.anova.pooled:
            notes.append(
                f"the interaction (p = {row.p:.3g} > {POOL_ABOVE:g}) is pooled with repeatability"
            )
        notes += [
            f"the variance of {name} came out below 0 and counts as 0"
            for name in self.anova.components.negative
        ]
        if self.ranges.av_negative:
            notes.append("average and range: the square of AV came out below 0 and counts as 0")
        return tuple(notes)

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        components = self.anova.components
        total, tolerance = self.sd("tv"), self.tolerance
        sds = {name: self.sd(name) for name in NAMES}
        percent = None if tolerance is None else 100 * self.multiplier / tolerance
        of_total = percent_of_total(components.part_to_gauge)
        return {
            **sds,
            **{f"{name}_ci": ends(self.sd_ci(name)) for name in NAMES},
            "ndc": self.ndc,
            "grr_percent_tv": 100 * sds["grr"] / total,
            "grr_percent_tv_ci": ends(of_total),
            "percent_tv": {name: 100 * sd / total for name, sd in sds.items()},
            "percent_contribution": {name: 100 * (sd / total) ** 2 for name, sd in sds.items()},
            "percent_tolerance": None
            if percent is None
            else {name: percent * sd for name, sd in sds.items()},
            "multiplier": self.multiplier,
            "tolerance_mm": tolerance,
            "parts": self.shape[0],
            "operators": self.shape[1],
            "trials": self.shape[2],
            "interaction_pooled": self.anova.pooled,
            "anova": [row.to_dict() for row in self.anova.rows],
            "average_and_range": self.ranges.to_dict(),
            "notes": list(self.notes),
        }


def assess_gauge(
    values: ArrayLike,
    *,
    tolerance: float | None = None,
    multiplier: float = MULTIPLIER,
    level: float = 0.95,
) -> Gauge:
    """Analyse a balanced gauge study, by analysis of variance and by averages and ranges.

    Parameters
    ----------
    values
        (p, o, r) part, operator, trial; at least 2 of each. `crossed` lays rows out so.
    tolerance
        USL - LSL, in the unit of the values, above 0.
    multiplier
        k of ``% of tolerance`` = 100 k SD / (USL - LSL), above 0.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        As `balanced`, or the tolerance or the multiplier is not above 0.
    """
    y = balanced(values)
    for name, number in (("tolerance", tolerance), ("multiplier", multiplier)):
        if number is not None and not (math.isfinite(number) and number > 0):
            raise ValueError(f"{name} is {number:g}: it has to be above 0")
    p, o, r = y.shape
    return Gauge((p, o, r), analyse(y, level), study_ranges(y), multiplier, tolerance)
