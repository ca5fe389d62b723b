"""Gauge repeatability and reproducibility by averages and ranges (AIAG MSA, 4th edition)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from simtip.capability.d2_star import d2_star
from simtip.capability.gauge_design import balanced


@dataclass(frozen=True)
class RangeStudy:
    """Standard deviations by averages and ranges; unit of the data.

    Attributes
    ----------
    ev, av, grr, pv, tv
        Repeatability, reproducibility, both, parts, all. This method knows no interaction.
    mean_range, operator_difference, part_range
        Mean range of the trials; largest less smallest mean of the operators, and of the parts.
    K1, K2, K3
        1 / d2* for the three.
    av_negative
        Whether the square of `av` came out below 0, and counts as 0.
    """

    ev: float
    av: float
    grr: float
    pv: float
    tv: float
    mean_range: float
    operator_difference: float
    part_range: float
    K1: float
    K2: float
    K3: float
    av_negative: bool

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            "ev": self.ev,
            "av": self.av,
            "grr": self.grr,
            "pv": self.pv,
            "tv": self.tv,
            "ndc": distinct_categories(self.pv, self.grr),
            "grr_percent_tv": 100 * self.grr / self.tv if self.tv else None,
            "mean_range": self.mean_range,
            "operator_difference": self.operator_difference,
            "part_range": self.part_range,
            "k1": self.K1,
            "k2": self.K2,
            "k3": self.K3,
        }


def study_ranges(values: ArrayLike) -> RangeStudy:
    """Analyse a balanced gauge study (p, o, r) of part, operator, trial by averages and ranges.

    Raises
    ------
    ValueError
        As `balanced`.
    """
    y = balanced(values)
    p, o, r = y.shape
    return from_ranges(
        mean_range=float((y.max(axis=2) - y.min(axis=2)).mean()),
        operator_difference=float(y.mean(axis=(0, 2)).max() - y.mean(axis=(0, 2)).min()),
        part_range=float(y.mean(axis=(1, 2)).max() - y.mean(axis=(1, 2)).min()),
        shape=(p, o, r),
        constants=(1 / d2_star(r, p * o), 1 / d2_star(o, 1), 1 / d2_star(p, 1)),
    )


def from_ranges(
    *,
    mean_range: float,
    operator_difference: float,
    part_range: float,
    shape: tuple[int, int, int],
    constants: tuple[float, float, float],
) -> RangeStudy:
    """Give the standard deviations from the ranges, AIAG's report form.

    EV = R K1, AV^2 = (X_diff K2)^2 - EV^2 / (p r), GRR^2 = EV^2 + AV^2, PV = R_p K3,
    TV^2 = GRR^2 + PV^2.

    Parameters
    ----------
    mean_range, operator_difference, part_range
        R, X_diff and R_p.
    shape
        Numbers of parts, operators and trials.
    constants
        K1, K2, K3.
    """
    p, _, r = shape
    K1, K2, K3 = constants
    ev = mean_range * K1
    square = (operator_difference * K2) ** 2 - ev**2 / (p * r)
    av = math.sqrt(max(square, 0))
    grr, pv = math.hypot(ev, av), part_range * K3
    return RangeStudy(
        ev=ev,
        av=av,
        grr=grr,
        pv=pv,
        tv=math.hypot(grr, pv),
        mean_range=mean_range,
        operator_difference=operator_difference,
        part_range=part_range,
        K1=K1,
        K2=K2,
        K3=K3,
        av_negative=square < 0,
    )


def distinct_categories(pv: float, grr: float) -> int | None:
    """Give ndc = 1.41 PV / GRR, cut to a whole number and at least 1; None if GRR is 0."""
    return None if grr == 0 else max(1, math.floor(1.41 * pv / grr))
