"""Limits of agreement of Bland & Altman, with their confidence intervals.

Differences are measured minus reference, in the unit of the data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from simtip.capability import quantiles
from simtip.capability.interval import Interval, finite, mean_interval, spread, tails


@dataclass(frozen=True)
class Limits:
    """Bias and limits of agreement.

    Attributes
    ----------
    bias, bias_ci
        Mean difference, and Student's t interval.
    sd
        Standard deviation of the differences: of the whole population of pairs if there are
        repeated measurements.
    lower, upper
        bias -+ z sd, z being the normal quantile of the share that lies between: 1.96 for 95 %.
    lower_ci, upper_ci
        An interval of each limit.
    method
        In words, with the source.
    within_sd, between_sd
        Components of sd with repeated measurements: within and between subjects; else None.
    notes
        What a reader has to know about these figures.
    """

    bias: float
    bias_ci: Interval
    sd: float
    lower: float
    lower_ci: Interval
    upper: float
    upper_ci: Interval
    method: str
    within_sd: float | None = None
    between_sd: float | None = None
    notes: tuple[str, ...] = ()


def limit_factor(share: float) -> float:
    """Give z of the limits between which that share of a normal population lies."""
    return quantiles.normal(tails(share)[1])


def exact_factors(n: int, z: float, level: float) -> tuple[float, float]:
    """Give k1, k2: the upper limit mu + z sigma lies in mean + k1 sd .. mean + k2 sd.

    Exact, by the noncentral t distribution with n - 1 degrees of freedom and noncentrality
    z sqrt(n): the one-sided tolerance factors of normal samples (Carkeet 2015, per limit).
    """
    root = math.sqrt(n)
    low, high = (quantiles.noncentral_student(p, n - 1, z * root) / root for p in tails(level))
    return low, high


def single_limits(differences: ArrayLike, *, share: float = 0.95, level: float = 0.95) -> Limits:
    """Give the limits of agreement if every subject was measured once.

    Parameters
    ----------
    differences
        (n,) independent differences, n at least 2.
    share
        Share of the population between the limits.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        There are too few differences, or one is not finite.
    """
    d = finite(differences, 2, "differences")
    n, bias, z = len(d), float(d.mean()), limit_factor(share)
    sd = spread(d)
    low, high = exact_factors(n, z, level)
    return Limits(
        bias=bias,
        bias_ci=mean_interval(bias, sd, n, level),
        sd=sd,
        lower=bias - z * sd,
        lower_ci=Interval(bias - high * sd, bias - low * sd),
        upper=bias + z * sd,
        upper_ci=Interval(bias + low * sd, bias + high * sd),
        method="one pair per subject, exact intervals by noncentral t (Carkeet 2015)",
    )
