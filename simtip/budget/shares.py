"""A total split among causes that act together: one at a time, all but one, and Shapley's way."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from simtip.geometry import Array

Subset = frozenset[int]


@dataclass(frozen=True, eq=False)
class Shares:
    """How a total is split; every figure is a mean over replicates, with its interval's ends.

    Attributes
    ----------
    total, rest
        (3,) mean, low, high of the value with all causes, and with none.
    shapley
        (causes, 3): what a cause adds, averaged over all orders in which causes can come. Their sum
        is total less rest, in every replicate.
    alone
        (causes, 3): what it adds to none.
    removed
        (causes, 3): what goes when it alone goes.
    replicates
        How many there are; with one there are no intervals.
    """

    total: Array
    rest: Array
    shapley: Array
    alone: Array
    removed: Array
    replicates: int


def split(values: Mapping[Subset, Array], causes: int, level: float) -> Shares:
    """Split a value that is known for every subset of causes.

    Shapley (1953), "A value for n-person games": the only split that is symmetric, linear, gives
    nothing to what changes nothing, and adds up.

    Parameters
    ----------
    values
        (replicates,) for each of the 2^causes subsets.
    causes
        How many there are.
    level
        Confidence level of the intervals: Student's t over replicates, which are independent.
    """
    everything, nothing = frozenset(range(causes)), frozenset[int]()
    total, rest = values[everything], values[nothing]
    shapley = [_shapley(values, cause, causes) for cause in range(causes)]
    alone = [values[frozenset([cause])] - rest for cause in range(causes)]
    removed = [total - values[everything - {cause}] for cause in range(causes)]
    return Shares(
        total=_summed(total, level),
        rest=_summed(rest, level),
        shapley=_stacked(shapley, level),
        alone=_stacked(alone, level),
        removed=_stacked(removed, level),
        replicates=len(total),
    )


def subsets(causes: int) -> list[Subset]:
    """List all subsets."""
    sizes = range(causes + 1)
    return [frozenset(one) for size in sizes for one in itertools.combinations(range(causes), size)]


def _shapley(values: Mapping[Subset, Array], cause: int, causes: int) -> Array:
    share = np.zeros(values[frozenset()].shape)
    for subset in subsets(causes):
        if cause not in subset:
            others = len(subset)
            weight = 1 / (causes * math.comb(causes - 1, others))
            share += weight * (values[subset | {cause}] - values[subset])
    return share


def _stacked(values: list[Array], level: float) -> Array:
    return np.array([_summed(one, level) for one in values]).reshape(-1, 3)


def _summed(replicates: Array, level: float) -> Array:
    """Give mean, low and high end; without spread, or with one replicate, all three are one."""
    mean, n = float(np.mean(replicates)), len(replicates)
    sd = float(np.std(replicates, ddof=1)) if n > 1 else 0.0
    half = stats.t.ppf((1 + level) / 2, n - 1) * sd / math.sqrt(n) if n > 1 else 0.0
    return np.array([mean, mean - half, mean + half])


def rank(shares: Sequence[float]) -> list[int]:
    """Order causes by their share, the largest first."""
    return sorted(range(len(shares)), key=lambda k: -shares[k])
