"""Where tips moved, in words: a shift that most conditions have in common is said once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from simtip.geometry import Array
from simtip.regress.change import BETTER, MOVED, SAME, SHIFT, UNTOLD, WORSE, Change
from simtip.regress.compared import Compared, worst
from simtip.regress.line import Line, few, p_text
from simtip.regress.quantities import Pair
from simtip.regress.tolerance import Tolerance

COMMON_SHARE = 0.75
"""Of conditions that have to have moved alike for it to be said of all."""

ALIKE_PX = 0.1
"""How near two shifts have to be to count as alike; or a fifth of them."""


def shift_lines(compared: Compared, pairs: Mapping[str, Pair], tolerance: Tolerance) -> list[Line]:
    """Say which tips moved, and by how much; the parameters are those of `said_of`."""
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
    sure = bool(pooled) or sum(map(bool, told.values())) >= COMMON_SHARE * len(vectors)
    large = bool(alike) and np.abs(common).max() > tolerance.bias_px
    if sure and large and len(alike) >= COMMON_SHARE * len(vectors):
        state = worst(states)
        text = f"tip moved by {_both(common)}, in {len(alike)} of {len(pairs)} conditions"
        rest = {name: changes for name, changes in told.items() if name not in alike}
        return [Line(state, SHIFT, tuple(alike), text), *_single_shifts(rest)]
    lines = _single_shifts(told)
    needle = [one for one in pooled if one.axis in ("along", "across")] or pooled
    if needle:
        parts = [f"{one.change:+.2f} px {one.axis} {_in(one)}" for one in needle]
        smallest = min(one.p for one in needle)
        lines.append(
            Line(
                worst(one.state for one in pooled),
                SHIFT,
                (),
                f"tip moved by {', '.join(parts)}, on average of all conditions, "
                f"{p_text(smallest)}",
            )
        )
    return lines


def _in(one: Change) -> str:
    return f"in the {one.view} view"


def _single_shifts(
    told: Mapping[str, Sequence[Change]],
) -> list[Line]:
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
        lines.append(Line(state, SHIFT, tuple(mine), f"tip moved{where} {few(parts)}"))
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
