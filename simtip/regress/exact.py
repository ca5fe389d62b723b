"""Exact tests of two samples, whatever the values' distribution and however many are equal.

Under the hypothesis that nothing has changed, before and after can be exchanged: within a stratum
(two samples), or within each pair. So all p-values hold for detectors that give whole pixels, or
the same value every time, as well.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import stats

from simtip.geometry import Array

MOST_RANKED = 120
"""Values of a stratum, above which the normal approximation stands in."""

MOST_STATES = 400_000
"""Likewise, of the sums of all strata; and of the squared number of pairs."""


FEW_STRATA, NEARLY_RIGHT = 4, 1e-7
"""Of more strata the sums are worked out by Fourier transforms, so that p is right to 1e-10; if it
comes out below 1e-7, once more without them."""


@dataclass(frozen=True)
class Tested:
    """What a test says.

    Attributes
    ----------
    p
        Two-sided.
    least_p
        The least that it could have said with so many values.
    """

    p: float
    least_p: float


def rank_sum(before: Array, after: Array) -> Tested:
    """Test two independent samples: Wilcoxon's rank sum, with midranks, given the ties."""
    return stratified_rank_sum([(before, after)])


def stratified_rank_sum(strata: Sequence[tuple[Array, Array]]) -> Tested:
    """Test two independent samples in strata: the sum of Wilcoxon's rank sums.

    Parameters
    ----------
    strata
        Each (n,) before and (m,) after; those where either is empty tell nothing.
    """
    strata = [(x, y) for x, y in strata if len(x) and len(y)]
    if not strata:
        return Tested(1.0, 1.0)
    log_least = sum(
        math.lgamma(len(x) + 1) + math.lgamma(len(y) + 1) - math.lgamma(len(x) + len(y) + 1)
        for x, y in strata
    )
    least = min(1.0, 2 * math.exp(max(log_least, -700.0)))
    told = [_ranked(x, y) for x, y in strata]
    told = [one for one in told if one[0].any()]
    if not told:  # all are equal
        return Tested(1.0, least)
    observed = sum(int(ranks[len(ranks) - m :].sum()) for ranks, m in told)
    large = any(len(ranks) > MOST_RANKED for ranks, _ in told)
    if large or sum(int(ranks.sum()) for ranks, _ in told) > MOST_STATES:
        return Tested(_normal_p(told, observed), least)
    strata_told = tuple((_sorted(ranks), m) for ranks, m in told)
    if len(told) > FEW_STRATA:
        p = _two_sided(_nearly_sums_of_all(strata_told), observed)
        if p >= NEARLY_RIGHT:
            return Tested(p, least)
    return Tested(_two_sided(_sums_of_all(strata_told), observed), least)


def critical_rank_sum(n: int, level: float) -> float | None:
    """Give the least rank sum of n values after n others that is significant, without ties.

    Parameters
    ----------
    n
        Before, and as many after.
    level
        Two-sided.

    Returns
    -------
    sum
        Of the ranks 0, 1, ..; None if not even the largest is.
    """
    chances = _subset_sums(_sorted(np.arange(2 * n)), n)
    above = np.cumsum(chances[::-1])[::-1]
    enough = np.flatnonzero(2 * above <= level)
    return float(enough[0]) if len(enough) else None


def signed_rank(differences: Array) -> Tested:
    """Test pairs: Wilcoxon's signed ranks, zeros left out, with midranks, given the ties.

    With values of one size it is the sign test, of marks 0 and 1 McNemar's exact one.

    Parameters
    ----------
    differences
        (n,) after - before.
    """
    moved = differences[differences != 0]
    least = min(1.0, 2.0 ** (1 - len(differences)))
    if not len(moved):
        return Tested(1.0, least)
    ranks = np.rint(2 * stats.rankdata(np.abs(moved))).astype(np.int64)
    positive = int(ranks[moved > 0].sum())
    if len(moved) ** 2 > MOST_STATES:
        mean, variance = ranks.sum() / 2, float((ranks.astype(np.float64) ** 2).sum()) / 4
        z = max(abs(positive - mean) - 0.5, 0) / math.sqrt(variance)
        return Tested(min(1.0, 2 * float(stats.norm.sf(z))), least)
    pmf = np.ones(1)
    for rank in ranks:
        pmf = 0.5 * (np.pad(pmf, (0, rank)) + np.pad(pmf, (rank, 0)))
    return Tested(_two_sided(pmf, positive), least)


def paired_t(differences: Array, floor: float) -> Tested:
    """Test pairs by Student's t, the standard deviation being `floor` at least.

    Ranks of a dozen pairs can never tell much, be the shift as clear as it may. Where all
    differences are equal, the floor stands for what the pairs do not show.

    Parameters
    ----------
    differences
        (n,) after - before.
    floor
        In their unit.
    """
    n = len(differences)
    if n < 2:
        return Tested(1.0, 1.0)
    deviation = max(float(np.std(differences, ddof=1)), floor)
    t = abs(float(np.mean(differences))) / (deviation / math.sqrt(n))
    return Tested(min(1.0, 2 * float(stats.t.sf(t, n - 1))), 0.0 if n > 2 else 1.0)


def holm(p: Sequence[float], level: float) -> list[bool]:
    """Say which of several tests are significant, so that any is by chance at this level (Holm).

    Parameters
    ----------
    p
        Of all tests.
    level
        Of the family.
    """
    found = [False] * len(p)
    for rank, k in enumerate(sorted(range(len(p)), key=lambda k: p[k])):
        if p[k] > level / (len(p) - rank):
            break
        found[k] = True
    return found


def _ranked(before: Array, after: Array) -> tuple[NDArray[np.int64], int]:
    """Give doubled midranks less the least of them, before and after, and how many are after."""
    values = np.concatenate([before, after])
    ordered = np.sort(values)
    ranks = np.searchsorted(ordered, values) + np.searchsorted(ordered, values, side="right")
    return ranks - ranks.min(), len(after)


def _sorted(ranks: NDArray[np.int64]) -> tuple[int, ...]:
    return tuple(np.sort(ranks).tolist())


@lru_cache(maxsize=32)
def _nearly_sums_of_all(strata: tuple[tuple[tuple[int, ...], int], ...]) -> Array:
    """Give what `_sums_of_all` does, each chance to some 1e-16, by Fourier transforms."""
    # Strata without ties are often the same.
    chances = [(_subset_sums(*one), times) for one, times in Counter(strata).items()]
    size = sum(times * (len(one) - 1) for one, times in chances) + 1
    fast = scipy.fft.next_fast_len(size, real=True)
    spectrum: NDArray[np.complex128] = np.ones(1, np.complex128)
    for one, times in chances:
        spectrum = spectrum * scipy.fft.rfft(one, fast) ** times
    pmf: Array = np.maximum(scipy.fft.irfft(spectrum, fast)[:size], 0)
    pmf.setflags(write=False)
    return pmf


# Values without ties have the same ranks in every test, and a suite of many conditions asks often.
@lru_cache(maxsize=32)
def _sums_of_all(strata: tuple[tuple[tuple[int, ...], int], ...]) -> Array:
    """Give the distribution of the sum over strata, each of its sorted ranks and its m."""
    pmf, *others = (_subset_sums(ranks, m) for ranks, m in strata)
    for other in others:
        pmf = np.convolve(pmf, other)
    pmf.setflags(write=False)
    return pmf


@lru_cache(maxsize=512)
def _subset_sums(ranks: tuple[int, ...], m: int) -> Array:
    """Give the distribution of the sum of m of these sorted ranks, each choice as likely as any."""
    counts = np.zeros((m + 1, sum(ranks[-m:]) + 1))
    counts[0, 0] = 1
    for k, rank in enumerate(ranks):
        # Only sums that there are yet, and that ranks to come can still bring to m of them.
        low, high = max(m - len(ranks) + k, 0), min(k + 1, m)
        width = sum(ranks[k - high + 1 : k]) + 1
        counts[low + 1 : high + 1, rank : rank + width] += counts[low:high, :width].copy()
    chosen: Array = counts[m] / counts[m].sum()
    chosen.setflags(write=False)
    return chosen


def _normal_p(told: Sequence[tuple[NDArray[np.int64], int]], observed: int) -> float:
    mean = variance = 0.0
    for ranks, m in told:
        size = len(ranks)
        mean += m * float(ranks.mean())
        variance += m * (size - m) / (size - 1) * float(ranks.var())
    z = max(abs(observed - mean) - 0.5, 0) / math.sqrt(variance)
    return min(1.0, 2 * float(stats.norm.sf(z)))


def _two_sided(pmf: Array, observed: int) -> float:
    below, above = float(pmf[: observed + 1].sum()), float(pmf[observed:].sum())
    return min(1.0, 2 * min(below, above))
