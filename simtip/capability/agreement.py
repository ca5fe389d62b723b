"""Do two methods agree? Bland-Altman analysis, correlation and concordance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from simtip.capability.concordance import Concordance, concordance
from simtip.capability.interval import Array, Interval, ends, paired, spread
from simtip.capability.limits import Limits, single_limits
from simtip.capability.regression import (
    Regression,
    breusch_pagan,
    correlation,
    correlation_interval,
    regress,
)
from simtip.capability.repeated_limits import TrueValue, repeated_limits

SHAPIRO_MOST = 5000
"""Above so many values Shapiro and Wilk's p value is not to be trusted."""

FEW_PAIRS = 20
FEW = "the interval of Lin's concordance holds the truth in 92 to 94 of 100 cases with so few pairs"
"""Found by simulation for a 95 % interval: Lin's variance is that of many pairs."""


@dataclass(frozen=True)
class Agreement:
    """Agreement of measured with reference values; differences are measured minus reference.

    Attributes
    ----------
    n, share, level
        Pairs; share of the population between the limits; confidence level of the intervals.
    limits
        Bias and limits of agreement.
    proportional
        The difference regressed on the mean of the two. The p value of its slope is that of the
        Pitman-Morgan test too: that both methods have one variance.
    heteroscedasticity_p
        Breusch-Pagan, in Koenker's form, of that regression.
    normality_p
        Shapiro and Wilk's, of the differences.
    pearson_r, pearson_r_ci
        Correlation, Fisher's interval.
    concordance
        Lin's coefficient.
    notes
        What a reader has to know about these figures.
    """

    n: int
    share: float
    level: float
    limits: Limits
    proportional: Regression | None
    heteroscedasticity_p: float | None
    normality_p: float | None
    pearson_r: float | None
    pearson_r_ci: Interval | None
    concordance: Concordance | None
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        limits, ccc, line = self.limits, self.concordance, self.proportional
        return {
            "n": self.n,
            "share": self.share,
            "method": limits.method,
            "bias_mm": limits.bias,
            "bias_ci_mm": ends(limits.bias_ci),
            "sd_mm": limits.sd,
            "within_sd_mm": limits.within_sd,
            "between_sd_mm": limits.between_sd,
            "loa_lower_mm": limits.lower,
            "loa_lower_ci_mm": ends(limits.lower_ci),
            "loa_upper_mm": limits.upper,
            "loa_upper_ci_mm": ends(limits.upper_ci),
            "proportional_bias": None if line is None else line.to_dict(),
            "pitman_morgan_p": None if line is None else line.slope_p,
            "heteroscedasticity_p": self.heteroscedasticity_p,
            "normality_p": self.normality_p,
            "pearson_r": self.pearson_r,
            "pearson_r_ci": ends(self.pearson_r_ci),
            "ccc": None if ccc is None else ccc.ccc,
            "ccc_ci": None if ccc is None else ends(ccc.ccc_ci),
            "ccc_bias_correction": None if ccc is None else ccc.bias_correction,
            "notes": list(self.notes),
        }


def assess_agreement(
    measured: ArrayLike,
    reference: ArrayLike,
    *,
    subjects: Sequence[object] | None = None,
    true_value: TrueValue | None = None,
    share: float = 0.95,
    level: float = 0.95,
) -> Agreement:
    """Compare measured values with reference values, pair by pair.

    Parameters
    ----------
    measured, reference
        (n,) pairs, n at least 3.
    subjects
        (n,) which subject (part) a pair is of, or None if every pair is of another.
    true_value
        Whether the true value of a subject ``varies`` between its pairs or is ``constant``:
        then the limits are those of repeated measurements. None takes every pair as independent.
    share
        Share of the population between the limits.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        There are too few pairs, lengths differ, a number is not finite, or repeated limits are
        asked for subjects that are not repeated.
    """
    y, x = paired(measured, reference, 3)
    scale = float(max(np.abs(y).max(), np.abs(x).max()))
    d = y - x
    if spread(d, scale) == 0:  # the rest of a subtraction is rounding
        d = np.full(len(d), d.mean())
    if true_value is None:
        limits = single_limits(d, share=share, level=level)
    elif subjects is None:
        raise ValueError("limits for repeated measurements need the subject of each pair")
    else:
        limits = repeated_limits(y, x, subjects, true_value=true_value, share=share, level=level)
    r = correlation(y, x)
    line = regress(d, (y + x) / 2, level)
    normality = _normality(d)
    ignored = true_value is None and subjects is not None and len(set(subjects)) < len(y)
    return Agreement(
        n=len(y),
        share=share,
        level=level,
        limits=limits,
        proportional=line,
        heteroscedasticity_p=_heteroscedasticity(d, (y + x) / 2, line),
        normality_p=normality,
        pearson_r=r,
        pearson_r_ci=None if r is None else correlation_interval(r, len(y), level),
        concordance=None if r is None else concordance(y, x, level),
        notes=(
            *limits.notes,
            *_notes(normality, repeated=true_value is not None, ignored=ignored),
            *([FEW] if len(y) < FEW_PAIRS else []),
        ),
    )


def _heteroscedasticity(d: Array, mean: Array, line: Regression | None) -> float | None:
    if line is None or line.slope_p is None:
        return None
    return breusch_pagan(d - line.intercept - line.slope * mean, mean)


def _normality(d: Array) -> float | None:
    sd = spread(d)
    if not 3 <= len(d) <= SHAPIRO_MOST or sd == 0:
        return None
    # SciPy takes very small numbers for equal ones.
    return float(stats.shapiro((d - d.mean()) / sd).pvalue)


def _notes(normality: float | None, *, repeated: bool, ignored: bool) -> list[str]:
    notes = []
    if normality is not None and normality < 0.05:
        notes.append(
            f"the differences do not look normal (Shapiro-Wilk p = {normality:.2g}): limits and "
            "intervals presume that they are"
        )
    if repeated:
        notes.append("correlations, p values and concordance take every pair as independent")
    if ignored:
        notes.append(
            "some parts have several pairs, each taken as independent: intervals may be too narrow"
        )
    return notes
