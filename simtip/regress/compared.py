"""A suite's conditions before and after: every test, corrected for how many there are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from simtip.regress.change import BETTER, DETECTION, MOVED, OUTLIERS, SAME, UNTOLD, WORSE, Change
from simtip.regress.exact import holm
from simtip.regress.pooled import pooled_changes
from simtip.regress.quantities import Pair, changes_of
from simtip.regress.tolerance import Tolerance

LEVEL = 0.001
"""Of each of four families of tests, so that at most 0.4 % of checks of an unchanged detector say
anything: detection in all conditions; outliers; shifts and spreads; every condition alone."""

PAIRED_LEVEL = 0.004
"""Of the first one on the same images, on which an unchanged detector mostly finds the same: nine
tips lost, and none gained, count."""

SUSPICIOUS = 0.01
"""On the same images every change is the detector's; with such a p it is not said to be none."""

ORDER = (WORSE, UNTOLD, MOVED, BETTER, SAME)
"""Of states, the worst first."""


@dataclass(frozen=True)
class Compared:
    """What is said of conditions that can be compared.

    Attributes
    ----------
    conditions
        Changes of each, by name.
    pooled
        Changes of all together.
    paired
        Whether on the same images.
    """

    conditions: Mapping[str, Sequence[Change]]
    pooled: Sequence[Change]
    paired: bool

    @property
    def changes(self) -> list[tuple[str | None, Change]]:
        """All, with the condition's name or None."""
        own = [(name, one) for name, changes in self.conditions.items() for one in changes]
        return [*((None, one) for one in self.pooled), *own]

    @property
    def state(self) -> str:
        """The worst of all."""
        return worst(one.state for _, one in self.changes)

    @property
    def tests(self) -> int:
        """How many tests there are of single conditions."""
        return sum(len(changes) for changes in self.conditions.values())


def worst(states: Iterable[str]) -> str:
    """Give the worst of some states; the same if there is none."""
    found = set(states)
    return next((state for state in ORDER if state in found), SAME)


def compare(pairs: Mapping[str, Pair], tolerance: Tolerance, *, paired: bool) -> Compared:
    """Test conditions alone and together.

    Parameters
    ----------
    pairs
        By the condition's name.
    tolerance
        What is left alone.
    paired
        Whether all are of the same images.
    """
    if not pairs:
        return Compared({}, (), paired)
    alone = {name: changes_of(pair, tolerance) for name, pair in pairs.items()}
    detection, others = pooled_changes(list(pairs.values()), tolerance)
    flat = _judged([one for changes in alone.values() for one in changes], LEVEL, paired=paired)
    judged = iter(flat)
    conditions = {name: [next(judged) for _ in changes] for name, changes in alone.items()}
    level = detection_level(paired=paired)
    pooled = [
        *_judged([detection], level, paired=paired),
        *_judged([one for one in others if one.kind == OUTLIERS], LEVEL, paired=paired),
        *_judged([one for one in others if one.kind != OUTLIERS], LEVEL, paired=paired),
    ]
    return Compared(conditions, _without_doubt(pooled, flat), paired)


def detection_level(*, paired: bool) -> float:
    """Give the level of the test of all conditions' detections."""
    return PAIRED_LEVEL if paired else LEVEL


def _judged(family: Sequence[Change], level: float, *, paired: bool) -> list[Change]:
    """Say of a family's tests what they tell."""
    significant = holm([one.p for one in family], level)
    return [
        one.judged(significant=found, doubtful=paired and _is_doubtful(one))
        for one, found in zip(family, significant, strict=True)
    ]


def _is_doubtful(one: Change) -> bool:
    """Say whether a change on the same images that is not significant may not be called none.

    Any tip there that is lost, or far off, is the detector's doing.
    """
    return one.kind in (DETECTION, OUTLIERS) or one.p <= SUSPICIOUS


def _without_doubt(pooled: list[Change], alone: Sequence[Change]) -> list[Change]:
    """Leave doubts out about what is sure of single conditions."""
    sure = {one.kind for one in alone if one.state == WORSE}
    return [
        one.judged(significant=False, doubtful=False)
        if one.state == UNTOLD and one.kind in sure
        else one
        for one in pooled
    ]
