"""Limits of agreement where subjects were measured several times.

Bland & Altman (1999, 2007); intervals of Zou (2013).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.capability import quantiles
from simtip.capability.interval import (
    RESOLUTION,
    Array,
    Interval,
    mover,
    paired,
    spread,
    tails,
    variance_interval,
)
from simtip.capability.limits import Limits, limit_factor

NDArrayInt: TypeAlias = NDArray[np.intp]

Weighting: TypeAlias = Literal["pairs", "subjects"]
"""What counts alike if subjects have unequal numbers of pairs: Bland & Altman 2007; Zou 2013."""

TrueValue: TypeAlias = Literal["varies", "constant"]


def repeated_limits(
    measured: ArrayLike,
    reference: ArrayLike,
    subjects: Sequence[object],
    *,
    true_value: TrueValue = "varies",
    weighting: Weighting = "pairs",
    share: float = 0.95,
    level: float = 0.95,
) -> Limits:
    """Give the limits of agreement if subjects were measured several times.

    The limits are for one measurement by each method (Bland & Altman 1999, 2007); their intervals
    are MOVER's (Zou 2013), that of the bias Student's t.

    Parameters
    ----------
    measured, reference
        (n,) pairs.
    subjects
        (n,) which subject (part) a pair is of; numbers of pairs may be unequal.
    true_value
        ``varies``: it changes from pair to pair, and the two of a pair were measured together;
        components of the differences by one-way ANOVA. ``constant``: it is one value per subject,
        so that pairs mean nothing; components of each method by one-way ANOVA.
    weighting
        ``pairs``: bias over all pairs, ANOVA's divisor for unequal numbers (Bland & Altman 2007).
        ``subjects``: over the subjects' means (Zou 2013). Alike if the numbers are equal.
    share, level
        As for `single_limits`.

    Raises
    ------
    ValueError
        There are fewer than two subjects, no subject was measured twice, lengths differ, or a
        number is not finite.
    """
    y, x = paired(measured, reference, 3)
    groups = _groups(subjects, len(y))
    counts = np.bincount(groups).astype(np.float64)
    if len(counts) < 2 or len(counts) == len(y):
        raise ValueError("repeated measurements need two subjects, one of them measured twice")
    d = y - x
    scale = float(max(np.abs(y).max(), np.abs(x).max()))
    means, within = _one_way(d, groups, counts, scale)
    between_means = spread(means, scale) ** 2
    if true_value == "varies":
        errors = [within]
    else:
        errors = [_one_way(v, groups, counts, scale)[1] for v in (y, x)]
    parts = _Parts(d, counts, means, between_means, within, errors)
    bias, error, freedom = parts.bias(weighting)
    between, total = parts.variances(weighting, true_value)
    z, sd = limit_factor(share), math.sqrt(total)
    reach = quantiles.student(tails(level)[1], freedom) * error
    bias_ci = Interval(bias - reach, bias + reach)
    sd_ci = parts.total_interval(total, level).root()
    # Zou takes the normal quantile for the bias here: Student's would make the limits' too wide.
    half = limit_factor(level) * error
    place = Interval(bias - half, bias + half)
    lower_ci = mover([bias, -z * sd], [place, Interval(-z * sd_ci.high, -z * sd_ci.low)])
    upper_ci = mover([bias, z * sd], [place, sd_ci.scaled(z)])
    notes = ("the variance between parts came out below 0: it is shown as 0",)
    return Limits(
        bias=bias,
        bias_ci=bias_ci,
        sd=sd,
        lower=bias - z * sd,
        lower_ci=lower_ci,
        upper=bias + z * sd,
        upper_ci=upper_ci,
        method=f"repeated pairs per subject, true value {true_value} (Bland & Altman 2007), "
        "intervals by MOVER (Zou 2013)",
        within_sd=math.sqrt(sum(errors)),
        between_sd=math.sqrt(max(between, 0)),
        notes=notes if between < 0 else (),
    )


@dataclass(frozen=True)
class _Parts:
    """What repeated differences are made of: subjects' means, and mean squares within.

    `errors` are the mean squares that the variance of one pair's difference takes from within
    subjects: of the differences, or of each method.
    """

    differences: Array
    counts: Array
    means: Array
    variance_of_means: float
    within: float
    errors: list[float]

    @property
    def harmonic(self) -> float:
        """Harmonic mean of the numbers of pairs."""
        return len(self.counts) / float((1 / self.counts).sum())

    def bias(self, weighting: Weighting) -> tuple[float, float, float]:
        """Give the mean difference, its standard error and the error's degrees of freedom."""
        n, pairs = len(self.counts), float(self.counts.sum())
        if weighting == "subjects":
            return float(self.means.mean()), math.sqrt(self.variance_of_means / n), n - 1
        # share x between + within / N, as mean squares; Satterthwaite's degrees of freedom.
        share = float((self.counts**2).sum()) / pairs**2 / self.divisor
        terms = (share * self.square_between, (1 / pairs - share) * self.within)
        variance = max(sum(terms), 0)
        spent = terms[0] ** 2 / (n - 1) + terms[1] ** 2 / (pairs - n)
        freedom = variance**2 / spent if variance and spent else n - 1.0
        return float(self.differences.mean()), math.sqrt(variance), max(freedom, 1.0)

    def variances(self, weighting: Weighting, true_value: TrueValue) -> tuple[float, float]:
        """Give the variance between subjects, and that of one pair's difference."""
        if weighting == "subjects" or true_value == "constant":
            between = self.variance_of_means - sum(self.errors) / self.harmonic
        else:
            between = self.between_by_anova
        # Not cut off at 0: the sum is unbiased as it is, and hardly ever below 0.
        return between, max(between + sum(self.errors), 0)

    @property
    def between_by_anova(self) -> float:
        """Variance of the differences between subjects, with the divisor for unequal numbers."""
        return (self.square_between - self.within) / self.divisor

    @property
    def square_between(self) -> float:
        """Mean square of the differences between subjects."""
        centre = float(self.differences.mean())
        return float((self.counts * (self.means - centre) ** 2).sum()) / (len(self.counts) - 1)

    @property
    def divisor(self) -> float:
        """What stands in for the number of pairs per subject if these are unequal."""
        pairs = float(self.counts.sum())
        return (pairs**2 - float((self.counts**2).sum())) / ((len(self.counts) - 1) * pairs)

    def total_interval(self, total: float, level: float) -> Interval:
        """Give the interval of the total variance, recovered from those of its mean squares."""
        n, pairs = len(self.counts), int(self.counts.sum())
        terms = [(self.variance_of_means, n - 1)]
        terms += [((1 - 1 / self.harmonic) * error, pairs - n) for error in self.errors]
        values = [value for value, _ in terms]
        found = mover(values, [variance_interval(v, f, level) for v, f in terms])
        shift = total - sum(values)
        return Interval(found.low + shift, found.high + shift)


def _groups(subjects: Sequence[object], count: int) -> NDArrayInt:
    if len(subjects) != count:
        raise ValueError(f"{len(subjects)} subjects do not go with {count} pairs")
    index: dict[object, int] = {}
    return np.array([index.setdefault(subject, len(index)) for subject in subjects])


def _one_way(values: Array, groups: NDArrayInt, counts: Array, scale: float) -> tuple[Array, float]:
    """Give the groups' means, and the mean square within groups; rounding counts as 0."""
    means = np.bincount(groups, weights=values) / counts
    freedom = len(values) - len(counts)
    within = float(((values - means[groups]) ** 2).sum()) / freedom
    return means, within if within > (RESOLUTION * scale) ** 2 else 0.0
