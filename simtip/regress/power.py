"""The least change that a test sees nine times of ten, at the level that its family leaves it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from scipy import optimize, stats

from simtip.geometry import Array
from simtip.regress.exact import critical_rank_sum, rank_sum

POWER = 0.9
DRAWS = 4000
MOST_RATIO = 20.0
"""Of spreads, that is looked for."""

MOST_SIMULATED = 60
"""Trials of a condition, above which the normal approximation stands in."""

RANKS_EFFICIENCY = 3 / math.pi
"""Of rank sums against Student's t with normal values."""


def power_of_condition(trials: int, tests: int, level: float) -> dict[str, Any]:
    """Say what is seen of one condition with fresh noise, normal errors and all tips found.

    Parameters
    ----------
    trials
        Before, and as many after.
    tests
        In the family.
    level
        Of the family.

    Returns
    -------
    power
        ``shift_sigma``, ``spread_ratio`` and ``loss`` (share of detections); None if nothing can
        be seen, however large.
    """
    alpha = level / max(tests, 1)
    return {
        "shift_sigma": least_shift(trials, alpha),
        "spread_ratio": least_ratio(trials, 1, alpha),
        "loss": least_loss(trials, alpha),
    }


def power_of_all(
    trials: int, conditions: int, tests: int, level: float, detection_level: float
) -> dict[str, Any]:
    """Say what is seen of all conditions together, likewise.

    Parameters
    ----------
    trials
        Of each condition.
    conditions
        How many.
    tests
        In the family besides detection, which is alone in its own.
    level, detection_level
        Of both families.
    """
    alpha = level / max(tests, 1)
    total = trials * conditions
    if not total:
        return {"shift_sigma": None, "spread_ratio": None, "loss": None}
    together = _normal_shift(total, alpha) if total > 1 else None
    return {
        "shift_sigma": together,
        "spread_ratio": least_ratio(trials, conditions, alpha),
        "loss": least_pooled_loss(total, detection_level),
    }


@cache
def least_shift(n: int, alpha: float) -> float | None:
    """Give the shift in standard deviations that a rank sum of n and n sees."""
    if n > MOST_SIMULATED:
        return _normal_shift(n, alpha)
    return _least(n, alpha, lambda x, y, by: (x, y + by), (0.0, 60.0))


def _normal_shift(n: int, alpha: float) -> float:
    needed = float(stats.norm.isf(alpha / 2) + stats.norm.ppf(POWER))
    return needed * math.sqrt(2 / n) / math.sqrt(RANKS_EFFICIENCY)


@cache
def least_ratio(n: int, strata: int, alpha: float) -> float | None:
    """Give the ratio of standard deviations that rank sums of distances see.

    Of many values by their mean: of normal values, the one farther from its centre is of those
    with ``ratio`` times the scatter with the probability 2 atan(ratio) / pi.
    """
    if strata == 1 and n <= MOST_SIMULATED:
        return _least(n, alpha, lambda x, y, by: (np.abs(x), by * np.abs(y)), (1.0, MOST_RATIO))
    sigma = math.sqrt((2 * n + 1) / (12 * n * n * strata))
    needed = 0.5 + sigma * float(stats.norm.isf(alpha / 2) + stats.norm.ppf(POWER))
    return math.tan(0.5 * math.pi * needed) if needed < 0.98 else None


def _least(
    n: int,
    alpha: float,
    changed: Callable[[Array, Array, float], tuple[Array, Array]],
    ends: tuple[float, float],
) -> float | None:
    """Find by simulation which change a rank sum sees nine times of ten."""
    enough = critical_rank_sum(n, alpha)
    if n < 2 or enough is None:
        return None
    x, y = np.random.default_rng(n).normal(size=(2, DRAWS, n))

    def missed(by: float) -> float:
        before, after = changed(x, y, by)
        ranks = np.argsort(np.argsort(np.concatenate([before, after], axis=1), axis=1), axis=1)
        return float(np.mean(ranks[:, n:].sum(axis=1) >= enough)) - POWER

    if missed(ends[1]) < 0:
        return None
    return float(optimize.brentq(missed, *ends, xtol=1e-3))


@cache
def least_loss(n: int, alpha: float) -> float | None:
    """Give the share of lost detections that Fisher's test of n and n sees, all found before."""
    marks = [rank_sum(np.ones(n), (np.arange(n) >= k).astype(float)).p for k in range(n + 1)]
    enough = next((k for k, p in enumerate(marks) if p <= alpha), None)
    return None if enough is None else _share(n, enough)


def least_pooled_loss(n: int, alpha: float) -> float | None:
    """Give the share of n detections, on the same images, whose loss the sign test sees."""
    enough = math.ceil(1 - math.log2(alpha))
    return None if enough > n else _share(n, enough)


def _share(n: int, enough: int) -> float:
    """Give the rate at which `enough` of n are lost nine times of ten."""

    def missed(rate: float) -> float:
        return float(stats.binom.sf(enough - 1, n, rate)) - POWER

    return float(optimize.brentq(missed, 1e-9, 1 - 1e-12))
