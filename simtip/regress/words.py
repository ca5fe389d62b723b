"""What changed, in words: the worst first, what conditions have in common said once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.geometry import Array
from simtip.regress.change import (
    BETTER,
    DETECTION,
    MOVED,
    OUTLIERS,
    SAME,
    SHIFT,
    SPREAD,
    UNTOLD,
    WORSE,
    Change,
)
from simtip.regress.compared import ORDER, Compared, worst
from simtip.regress.quantities import Pair
from simtip.regress.tolerance import Tolerance

COMMON_SHARE = 0.75
"""Of conditions that have to have moved alike for it to be said of all."""

ALIKE_PX = 0.1
"""How near two shifts have to be to count as alike; or a fifth of them."""

MOST_NAMED = 4
"""Conditions that are named in one line."""


@dataclass(frozen=True)
class Said:
    """A line of the result.

    Attributes
    ----------
    state, kind
        See `simtip.regress.change`; the kind may be ``time`` or ``images``, too.
    where
        Names of the conditions; none is all.
    text
        In words.
    """

    state: str
    kind: str
    where: tuple[str, ...]
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Give plain values."""
        return {
            "state": self.state,
            "kind": self.kind,
            "where": list(self.where),
            "text": self.text,
        }


def said_of(
    compared: Compared,
    pairs: Mapping[str, Pair],
    failed: Mapping[str, Mapping[str, int]],
    tolerance: Tolerance,
) -> list[Said]:
    """Say what changed.

    Parameters
    ----------
    compared
        The tests.
    pairs
        The conditions, by name.
    failed
        Of each, statuses of trials without a tip now.
    tolerance
        What is left alone.
    """
    if not pairs:
        return []
    lines = [
        *_detections(compared, pairs, failed),
        *_shifts(compared, pairs, tolerance),
        *_spreads(compared),
        *_outliers(compared),
    ]
    sure = {line.kind for line in lines if line.state == WORSE}
    told = [line for line in lines if line.state != UNTOLD or line.kind not in sure]
    return sorted(told, key=lambda line: ORDER.index(line.state))


def _detections(
    compared: Compared, pairs: Mapping[str, Pair], failed: Mapping[str, Mapping[str, int]]
) -> list[Said]:
    lines = []
    pooled = next(one for one in compared.pooled if one.kind == DETECTION)
    own = {
        name: one
        for name, changes in compared.conditions.items()
        for one in changes
        if one.kind == DETECTION and one.state != SAME
    }
    if pooled.state != SAME:
        word = "lost" if pooled.change < 0 else "gained"
        text = f"detections {word}: {_how_many(pairs, paired=compared.paired)}, {_p(pooled.p)}"
        if pooled.change < 0:
            text += _most_often(failed.values())
        lines.append(Said(pooled.state, DETECTION, (), text))
    for state in ORDER:
        names = [name for name, one in own.items() if one.state == state]
        if not names:
            continue
        shown = [name for name in names if all(pairs[name].after.in_view)]
        if shown:
            told = [f"{name} ({_counts(pairs[name], failed.get(name, {}))})" for name in shown]
            word = "lost" if own[shown[0]].change < 0 else "gained"
            lines.append(Said(state, DETECTION, tuple(shown), f"detections {word} in {_few(told)}"))
        hidden = [name for name in names if name not in shown]
        if hidden:
            told = [f"{name} ({_tip_counts(pairs[name])})" for name in hidden]
            text = f"detections, the true tip being out of view, in {_few(told)}"
            lines.append(Said(state, DETECTION, tuple(hidden), text))
    return lines


def _how_many(pairs: Mapping[str, Pair], *, paired: bool) -> str:
    before = np.concatenate([pair.before.found for pair in pairs.values()])
    after = np.concatenate([pair.after.found for pair in pairs.values()])
    if not paired:
        return (
            f"{int(before.sum())} of {len(before)} pairs before, "
            f"{int(after.sum())} of {len(after)} now"
        )
    lost, gained = int((before & ~after).sum()), int((~before & after).sum())
    share = 100 * abs(lost - gained) / len(before)
    tips = [_tips(pair) for pair in pairs.values()]
    return (
        f"{share:.1f} % of {len(before)} pairs ({lost} lost, {gained} gained), "
        f"{sum(gone for gone, _ in tips)} of {sum(seen for _, seen in tips)} tips in images"
    )


def _most_often(failed: Iterable[Mapping[str, int]]) -> str:
    """Say with which status most trials without a tip end now."""
    counts: Counter[str] = Counter()
    for statuses in failed:
        counts.update(statuses)
    return f"; now most often {counts.most_common(1)[0][0]}" if counts else ""


def _tips(pair: Pair) -> tuple[int, int]:
    """Give how many tips in images are no longer seen, and of how many."""
    before, after = (np.stack([s.seen(0), s.seen(1)]) for s in (pair.before, pair.after))
    return int((before & ~after).sum()), int(before.sum())


def _counts(pair: Pair, failed: Mapping[str, int]) -> str:
    before, after = int(pair.before.found.sum()), int(pair.after.found.sum())
    text = f"{before} of {len(pair.before)} before, {after} of {len(pair.after)} now"
    if before == after:
        return _tip_counts(pair)
    if after < before and failed:
        text += f": {max(failed, key=lambda status: failed[status])}"
    return text


def _tip_counts(pair: Pair) -> str:
    before, after = (int(s.seen(0).sum() + s.seen(1).sum()) for s in (pair.before, pair.after))
    return f"tips in images: {before} before, {after} now"


def _shifts(compared: Compared, pairs: Mapping[str, Pair], tolerance: Tolerance) -> list[Said]:
    told = {
        name: [one for one in changes if one.kind == SHIFT and one.state != SAME]
        for name, changes in compared.conditions.items()
    }
    pooled = [one for one in compared.pooled if one.kind == SHIFT and one.state != SAME]
    if not pooled and not any(told.values()):
        return []
    vectors = {name: _shift_vector(pair) for name, pair in pairs.items()}
    vectors = {name: vector for name, vector in vectors.items() if not np.isnan(vector).any()}
    common, alike = _common(vectors)
    states = [one.state for changes in told.values() for one in changes]
    states += [one.state for one in pooled]
    large = np.abs(common).max() > tolerance.bias_px if len(alike) else False
    if large and len(alike) >= COMMON_SHARE * len(vectors):
        state = worst(states)
        text = f"tip moved by {_both(common)}, in {len(alike)} of {len(pairs)} conditions"
        rest = {name: changes for name, changes in told.items() if name not in alike}
        return [Said(state, SHIFT, tuple(alike), text), *_single_shifts(rest)]
    lines = _single_shifts(told)
    needle = [one for one in pooled if one.axis in ("along", "across")] or pooled
    if needle:
        parts = [f"{one.change:+.2f} px {one.axis} {_in(one)}" for one in needle]
        smallest = min(one.p for one in needle)
        lines.append(
            Said(
                worst(one.state for one in pooled),
                SHIFT,
                (),
                f"tip moved by {', '.join(parts)}, on average of all conditions, {_p(smallest)}",
            )
        )
    return lines


def _in(one: Change) -> str:
    return f"in the {one.view} view"


def _single_shifts(
    told: Mapping[str, Sequence[Change]],
) -> list[Said]:
    lines = []
    for state in (WORSE, UNTOLD, MOVED, BETTER):
        mine = {
            name: changes
            for name, changes in told.items()
            if changes and worst(one.state for one in changes) == state
        }
        if not mine:
            continue
        parts = [
            f"{name} ({', '.join(_shift_text(one) for one in changes)})"
            for name, changes in sorted(
                mine.items(), key=lambda item: -max(abs(one.change) for one in item[1])
            )
        ]
        where = f" in {len(mine)} conditions:" if len(mine) > 1 else " in"
        lines.append(Said(state, SHIFT, tuple(mine), f"tip moved{where} {_few(parts)}"))
    return lines


def _shift_text(one: Change) -> str:
    return (
        f"{one.view} {one.axis} {one.change:+.2f} px: "
        f"error {one.before or 0.0:+.2f} before, {one.after or 0.0:+.2f} now"
    )


def _shift_vector(pair: Pair) -> Array:
    """Give the shift of both views, u and v, (2, 2); NaN where too little is seen."""
    found = np.full((2, 2), np.nan)
    for view in range(2):
        x, y = pair.errors(view, needle=False)
        if len(x) and len(y):
            found[view] = y.mean(axis=0) - x.mean(axis=0)
    return found


def _common(vectors: Mapping[str, Array]) -> tuple[Array, list[str]]:
    """Give the shift that most conditions have in common, and which have it."""
    if len(vectors) < 2:
        return np.zeros((2, 2)), []
    stacked = np.stack(list(vectors.values()))
    centre: Array = np.median(stacked, axis=0)
    near = max(ALIKE_PX, 0.2 * float(np.abs(centre).max()))
    alike = [name for name, one in vectors.items() if np.abs(one - centre).max() <= near]
    return centre, alike


def _both(shift: Array) -> str:
    left, right = (f"({u + 0.0:+.2f}, {v + 0.0:+.2f}) px" for u, v in np.round(shift, 2))
    if np.abs(shift[0] - shift[1]).max() <= ALIKE_PX / 2:
        mean = np.round(shift.mean(axis=0), 2) + 0.0
        return f"({mean[0]:+.2f}, {mean[1]:+.2f}) px in both views"
    return f"{left} in the left view and {right} in the right one"


def _spreads(compared: Compared) -> list[Said]:
    lines = []
    for state in (WORSE, UNTOLD, BETTER):
        parts, names = [], []
        for name, changes in compared.conditions.items():
            mine = [one for one in changes if one.kind == SPREAD and one.state == state]
            if mine:
                names.append(name)
                parts.append(f"{name} ({', '.join(_spread_text(one) for one in mine)})")
        pooled = [one for one in compared.pooled if one.kind == SPREAD and one.state == state]
        if pooled:
            text = ", ".join(_spread_text(one) for one in pooled)
            lines.append(
                Said(
                    state,
                    SPREAD,
                    (),
                    f"spread of all conditions: {text}, {_p(min(one.p for one in pooled))}",
                )
            )
        if parts:
            lines.append(Said(state, SPREAD, tuple(names), f"spread: {_few(parts)}"))
    return lines


def _spread_text(one: Change) -> str:
    return f"{one.axis} the needle, {one.view} view, x {one.change:.2g}"


def _outliers(compared: Compared) -> list[Said]:
    lines = []
    pooled = next(one for one in compared.pooled if one.kind == OUTLIERS)
    if pooled.state != SAME:
        text = f"tips far off: {_far_off(pooled)}, {_p(pooled.p)}"
        lines.append(Said(pooled.state, OUTLIERS, (), text))
    for state in (WORSE, UNTOLD, BETTER):
        mine = {
            name: one
            for name, changes in compared.conditions.items()
            for one in changes
            if one.kind == OUTLIERS and one.state == state
        }
        if mine:
            told = [f"{name} ({_far_off(one)})" for name, one in mine.items()]
            lines.append(Said(state, OUTLIERS, tuple(mine), f"tips far off in {_few(told)}"))
    return lines


def _far_off(one: Change) -> str:
    before, after = 100 * (one.before or 0), 100 * (one.after or 0)
    return f"{before:.1f} % of pairs before, {after:.1f} % now"


def _few(parts: Sequence[str]) -> str:
    more = len(parts) - MOST_NAMED
    text = "; ".join(parts[:MOST_NAMED])
    return f"{text}; and {more} more" if more > 0 else text


def _p(p: float) -> str:
    return f"p = {p:.1g}" if p >= 1e-12 else "p < 1e-12"
