"""The least change that a test sees nine times of ten, at the level that its family leaves it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import optimize, stats

from simtip.regress.exact import rank_sum

POWER = 0.9
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
    together = _normal_shift(total, alpha) if total > 1 else None
    return {
        "shift_sigma": together,
        "spread_ratio": least_ratio(trials, conditions, alpha),
        "loss": least_pooled_loss(total, detection_level),
    }


def least_shift(n: int, alpha: float) -> float | None:
    """Give the shift in standard deviations that a rank sum of n and n sees."""
    if n < 2 or 2 / math.comb(2 * n, n) > alpha:
        return None
    critical = float(stats.t.isf(alpha / 2, 2 * n - 2))

    def missed(shift: float) -> float:
        seen = stats.nct.sf(critical, 2 * n - 2, shift * math.sqrt(n / 2))
        return float(seen) - POWER

    found = float(optimize.brentq(missed, 0, 60))
    return found / math.sqrt(RANKS_EFFICIENCY)


def _normal_shift(n: int, alpha: float) -> float:
    needed = float(stats.norm.isf(alpha / 2) + stats.norm.ppf(POWER))
    return needed * math.sqrt(2 / n) / math.sqrt(RANKS_EFFICIENCY)


def least_ratio(n: int, strata: int, alpha: float) -> float | None:
    """Give the ratio of standard deviations that rank sums of distances see, by their mean.

    Of normal values, the one farther from its centre is of those with ``ratio`` times the scatter
    with the probability 2 atan(ratio) / pi.
    """
    if strata == 1 and (n < 2 or 2 / math.comb(2 * n, n) > alpha):
        return None
    sigma = math.sqrt((2 * n + 1) / (12 * n * n * strata))
    needed = 0.5 + sigma * float(stats.norm.isf(alpha / 2) + stats.norm.ppf(POWER))
    return math.tan(0.5 * math.pi * needed) if needed < 0.98 else None


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
