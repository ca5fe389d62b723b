"""What changed, in words: the worst first, what conditions have in common said once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from simtip.regress.change import (
    BETTER,
    DETECTION,
    OUTLIERS,
    SAME,
    SPREAD,
    UNTOLD,
    WORSE,
    Change,
)
from simtip.regress.compared import ORDER, Compared
from simtip.regress.line import Line, few, p_text
from simtip.regress.moved import shift_lines
from simtip.regress.quantities import Pair
from simtip.regress.tolerance import Tolerance


def said_of(
    compared: Compared,
    pairs: Mapping[str, Pair],
    failed: Mapping[str, Mapping[str, int]],
    tolerance: Tolerance,
) -> list[Line]:
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
        *shift_lines(compared, pairs, tolerance),
        *_spreads(compared),
        *_outliers(compared),
    ]
    sure = {line.kind for line in lines if line.state == WORSE}
    told = [line for line in lines if line.state != UNTOLD or line.kind not in sure]
    return sorted(told, key=lambda line: ORDER.index(line.state))


def _detections(
    compared: Compared, pairs: Mapping[str, Pair], failed: Mapping[str, Mapping[str, int]]
) -> list[Line]:
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
        text = f"detections {word}: {_how_many(pairs, paired=compared.paired)}, {p_text(pooled.p)}"
        if pooled.change < 0:
            text += _most_often(failed.values())
        lines.append(Line(pooled.state, DETECTION, (), text))
    for state in ORDER:
        names = [name for name, one in own.items() if one.state == state]
        if not names:
            continue
        shown = [name for name in names if all(pairs[name].after.in_view)]
        if shown:
            told = [f"{name} ({_counts(pairs[name], failed.get(name, {}))})" for name in shown]
            word = "lost" if own[shown[0]].change < 0 else "gained"
            lines.append(Line(state, DETECTION, tuple(shown), f"detections {word} in {few(told)}"))
        hidden = [name for name in names if name not in shown]
        if hidden:
            told = [f"{name} ({_tip_counts(pairs[name])})" for name in hidden]
            text = f"detections, the true tip being out of view, in {few(told)}"
            lines.append(Line(state, DETECTION, tuple(hidden), text))
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


def _spreads(compared: Compared) -> list[Line]:
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
                Line(
                    state,
                    SPREAD,
                    (),
                    f"spread of all conditions: {text}, {p_text(min(one.p for one in pooled))}",
                )
            )
        if parts:
            lines.append(Line(state, SPREAD, tuple(names), f"spread: {few(parts)}"))
    return lines


def _spread_text(one: Change) -> str:
    return f"{one.axis} the needle, {one.view} view, x {one.change:.2g}"


def _outliers(compared: Compared) -> list[Line]:
    lines = []
    pooled = next(one for one in compared.pooled if one.kind == OUTLIERS)
    if pooled.state != SAME:
        text = f"tips far off: {_far_off(pooled)}, {p_text(pooled.p)}"
        lines.append(Line(pooled.state, OUTLIERS, (), text))
    for state in (WORSE, UNTOLD, BETTER):
        mine = {
            name: one
            for name, changes in compared.conditions.items()
            for one in changes
            if one.kind == OUTLIERS and one.state == state
        }
        if mine:
            told = [f"{name} ({_far_off(one)})" for name, one in mine.items()]
            lines.append(Line(state, OUTLIERS, tuple(mine), f"tips far off in {few(told)}"))
    return lines


def _far_off(one: Change) -> str:
    before, after = 100 * (one.before or 0), 100 * (one.after or 0)
    return f"{before:.1f} % of pairs before, {after:.1f} % now"
