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

MOST_LOGARITHM = 30.0
"""Of an interval's end over the mean: what is wider says nothing anyway, and shall not overflow."""


@dataclass(frozen=True, eq=False)
class Shares:
    """How a total is split; every figure is a mean over replicates and places, with its interval.

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
    replicates, places
        How many there are of each.
    """

    total: Array
    rest: Array
    shapley: Array
    alone: Array
    removed: Array
    replicates: int
    places: int


def split(values: Mapping[Subset, Array], causes: int, level: float) -> Shares:
    """Split a value that is known for every subset of causes.

    Shapley (1953), "A value for n-person games": the only split that is symmetric, linear, gives
    nothing to what changes nothing, and adds up.

    Parameters
    ----------
    values
        (replicates, places) for each of the 2^causes subsets.
    causes
        How many there are.
    level
        Confidence level of the intervals, see `grand_mean`.
    """
    everything, nothing = frozenset(range(causes)), frozenset[int]()
    total, rest = values[everything], values[nothing]
    shapley = [_shapley(values, cause, causes) for cause in range(causes)]
    alone = [values[frozenset([cause])] - rest for cause in range(causes)]
    removed = [total - values[everything - {cause}] for cause in range(causes)]
    return Shares(
        total=grand_mean(total, level, squares=True),
        rest=grand_mean(rest, level, squares=True),
        shapley=_stacked(shapley, level),
        alone=_stacked(alone, level),
        removed=_stacked(removed, level),
        replicates=total.shape[0],
        places=total.shape[1],
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
    return np.array([grand_mean(one, level) for one in values]).reshape(-1, 3)


def grand_mean(values: Array, level: float, *, squares: bool = False) -> Array:
    """Give mean, low and high end of values by replicate and place, both drawn at random.

    The mean's variance is (MS_r + MS_p) / (r p), mean squares of a two-way layout, without the
    residual's taken away. Student's t with Satterthwaite's (1946) degrees of freedom: for normal
    values rather too wide. Squares are skewed: their interval is that of the mean's logarithm.
    Differences of squares may be so, too: where the means of all replicates and all places have
    one sign, the end away from 0 is the logarithm's. What does not vary has no width.

    Parameters
    ----------
    values
        (replicates, places).
    level
        Confidence level.
    squares
        Whether they are squares, none of them below 0.
    """
    mean, count = float(values.mean()), values.size
    found, freedoms, one_sign = [], [], True
    for axis in (0, 1):
        means = values.mean(axis=1 - axis)
        one_sign &= bool((means > 0).all() or (means < 0).all())
        if len(means) > 1:
            found.append(count / len(means) * float(means.var(ddof=1)))
            freedoms.append(len(means) - 1)
    total = sum(found)
    if total == 0:
        return np.array([mean, mean, mean])
    freedom = total**2 / sum(ms**2 / df for ms, df in zip(found, freedoms, strict=True))
    half = float(stats.t.ppf((1 + level) / 2, freedom)) * math.sqrt(total / count)
    near, far = mean - math.copysign(half, mean), mean + math.copysign(half, mean)
    if one_sign:
        ratio = math.exp(min(half / abs(mean), MOST_LOGARITHM))
        near, far = mean / ratio if squares else near, mean * ratio
    return np.array([mean, *sorted((near, far))])


def rank(shares: Sequence[float]) -> list[int]:
    """Order causes by their share, the largest first."""
    return sorted(range(len(shares)), key=lambda k: -shares[k])
