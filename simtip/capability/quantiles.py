"""Quantiles of the distributions that intervals are made of, each worked out once.

A simulation asks for the same few again and again, and SciPy takes up to milliseconds for one.
"""

from __future__ import annotations

from functools import lru_cache

from scipy import stats

remembered = lru_cache(maxsize=1024)


@remembered
def normal(p: float) -> float:
    """Give the quantile of the standard normal distribution."""
    return float(stats.norm.ppf(p))


@remembered
def student(p: float, freedom: float) -> float:
    """Give the quantile of Student's t distribution."""
    return float(stats.t.ppf(p, freedom))


@remembered
def chi_square(p: float, freedom: float) -> float:
    """Give the quantile of the chi-square distribution."""
    return float(stats.chi2.ppf(p, freedom))


@remembered
def fisher(p: float, above: float, below: float) -> float:
    """Give the quantile of the F distribution, of a ratio of mean squares with such freedom."""
    return float(stats.f.ppf(p, above, below))


@remembered
def noncentral_student(p: float, freedom: float, shift: float) -> float:
    """Give the quantile of the noncentral t distribution."""
    return float(stats.nct.ppf(p, freedom, shift))
