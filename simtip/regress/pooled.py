"""What is tested of all conditions together: small changes that they have in common."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simtip.geometry import Array
from simtip.regress.change import DETECTION, OUTLIERS, Change
from simtip.regress.exact import Tested, signed_rank, stratified_rank_sum
from simtip.regress.quantities import (
    FEWEST,
    FLOOR_PX,
    SIDEWAYS,
    Pair,
    deviation,
    distances,
    rate_change,
    shift_change,
    spread_change,
)
from simtip.regress.sample import AXES, NEEDLE_AXES, VIEWS
from simtip.regress.tolerance import Tolerance

POOLED_SIGMA = 0.1
"""Of the usual scatter, that a shift common to all conditions has to be to count."""

Strata = list[tuple[Array, Array]]


def pooled_changes(pairs: Sequence[Pair], tolerance: Tolerance) -> tuple[Change, list[Change]]:
    """Test all conditions together: detection, and then all else.

    Parameters
    ----------
    pairs
        The conditions that can be compared, all of the same images or all with fresh noise.
    tolerance
        What is left alone.
    """
    paired = bool(pairs) and all(pair.paired for pair in pairs)
    found = [_rate(OUTLIERS, [pair.outliers for pair in pairs], paired, tolerance)]
    for view in range(2):
        for axis in range(2):
            found += _shifts(pairs, view, axis, paired, tolerance)
            found += _spreads(pairs, view, axis, paired, tolerance)
    detected = [(pair.before.detected, pair.after.detected) for pair in pairs]
    return _rate(DETECTION, detected, paired, tolerance), found


def _rate(kind: str, strata: Strata, paired: bool, tolerance: Tolerance) -> Change:
    strata = [(x, y) for x, y in strata if len(x) and len(y)]
    total = sum(len(x) for x, _ in strata)
    before = sum(float(x.sum()) for x, _ in strata) / max(total, 1)
    # With fresh noise there may be another number of trials: each condition counts as before.
    after = sum(float(y.mean()) * len(x) for x, y in strata) / max(total, 1)
    return rate_change(kind, before, after, _tested(strata, paired=paired), tolerance.rate)


def _tested(strata: Strata, *, paired: bool) -> Tested:
    if not paired:
        return stratified_rank_sum(strata)
    return signed_rank(np.concatenate([np.zeros(0), *(y - x for x, y in strata)]))


def _strata(pairs: Sequence[Pair], view: int, axis: int, *, needle: bool) -> Strata:
    errors = (pair.errors(view, needle=needle) for pair in pairs)
    return [(x[:, axis], y[:, axis]) for x, y in errors if min(len(x), len(y)) >= FEWEST]


def _shifts(
    pairs: Sequence[Pair], view: int, axis: int, paired: bool, tolerance: Tolerance
) -> list[Change]:
    found = []
    for needle, names in ((True, NEEDLE_AXES), (False, AXES)):
        strata = _strata(pairs, view, axis, needle=needle)
        if not strata:
            continue
        other = _strata(pairs, view, 1 - axis, needle=needle)
        sideways = abs(float(np.mean([y.mean() - x.mean() for x, y in other])))
        before = np.array([x.mean() for x, _ in strata])
        after = np.array([y.mean() for _, y in strata])
        scatter = float(np.sqrt(np.mean([deviation(x) ** 2 for x, _ in strata])))
        least = max(tolerance.bias_px, POOLED_SIGMA * scatter, SIDEWAYS * sideways)
        one = shift_change(
            *(VIEWS[view], names[axis], float(before.mean()), float(after.mean())),
            *(_tested(strata, paired=paired), least),
        )
        axes = (axis,) if needle else (0, 1)
        found.append(one.with_gain(_farther(pairs, view, axes, least)))
    return found


def _farther(pairs: Sequence[Pair], view: int, axes: Sequence[int], least: float) -> float:
    """Give by how much tips are farther from the truth along or across the needle, if it counts.

    Conditions err to both sides: what counts is how far from 0 each is. Of u and v, too: an error
    that is gone across a slanted needle may make another in v.
    """
    grown = []
    for axis in axes:
        strata = _strata(pairs, view, axis, needle=True)
        grown.append(float(np.mean([abs(y.mean()) - abs(x.mean()) for x, y in strata])))
    worst, best = max(grown), min(grown)
    # The side effect of a large shift is none of its own.
    if worst > max(least, SIDEWAYS * abs(best)):
        return worst
    return best if best < -least else 0.0


def _spreads(
    pairs: Sequence[Pair], view: int, axis: int, paired: bool, tolerance: Tolerance
) -> list[Change]:
    strata = _strata(pairs, view, axis, needle=True)
    if not strata:
        return []
    told = _tested([(distances(x), distances(y)) for x, y in strata], paired=paired)
    if not paired:
        middles = [np.quantile(np.concatenate(pair), 0.5, method="lower") for pair in strata]
        common = [(np.abs(x - m), np.abs(y - m)) for (x, y), m in zip(strata, middles, strict=True)]
        exact = _tested(common, paired=False)
        told = told if told.p >= exact.p else exact
    deviations = [
        (np.hypot(deviation(x), FLOOR_PX), np.hypot(deviation(y), FLOOR_PX)) for x, y in strata
    ]
    before, after = (float(np.exp(np.mean(np.log([one[k] for one in deviations])))) for k in (0, 1))
    one = spread_change(VIEWS[view], NEEDLE_AXES[axis], before, after, told, tolerance.spread)
    return [one.of_ratio(after / before)]
