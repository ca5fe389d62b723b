"""One quantity before and after: what changed, how sure that is, and whether it is worse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

WORSE, BETTER, MOVED, SAME, UNTOLD = "worse", "better", "moved", "same", "could not tell"
"""What may be said of a change. ``moved``: it changed, and is as far from the truth as before."""

DETECTION, SHIFT, SPREAD, OUTLIERS = "detection", "shift", "spread", "outliers"


@dataclass(frozen=True)
class Change:
    """One quantity, tested.

    Attributes
    ----------
    kind
        ``detection``, ``shift``, ``spread`` or ``outliers``.
    view, axis
        ``left``, ``right``, ``both``; ``u``, ``v``, ``along``, ``across`` or nothing.
    before, after
        Rate; mean error, px; standard deviation, px; share.
    change
        Of both, as the test has it: in pairs it is the mean of the differences.
    tolerance
        Below which a change is left alone: as `change`, but of spread a ratio.
    p, least_p
        Two-sided, and the least that so many trials could give.
    gain
        By how much it became worse: of a shift the growth of the distance from the truth.
    beyond
        Whether the change is larger than the tolerance.
    significant
        At the level of its family.
    state
        What is said of it.
    """

    kind: str
    view: str
    axis: str
    before: float | None
    after: float | None
    change: float
    tolerance: float
    p: float
    least_p: float
    gain: float
    beyond: bool
    significant: bool = False
    state: str = SAME

    def judged(self, *, significant: bool, doubtful: bool) -> Change:
        """Give it with what is said of it.

        Parameters
        ----------
        significant
            At the level of its family.
        doubtful
            Whether what looks worse is then not said to be none.
        """
        if not self.beyond:
            state = SAME
        elif significant:
            state = self._direction()
        else:
            state = UNTOLD if self._direction() == WORSE and doubtful else SAME
        return replace(self, significant=significant, state=state)

    def with_gain(self, gain: float) -> Change:
        """Give it with another measure of how much worse it became."""
        return replace(self, gain=gain)

    def of_ratio(self, ratio: float) -> Change:
        """Give a spread's change with a ratio of its own."""
        beyond = max(ratio, 1 / ratio) > self.tolerance
        return replace(self, change=ratio, gain=ratio - 1, beyond=beyond)

    def _direction(self) -> str:
        if self.gain > 0:
            return WORSE
        return BETTER if self.gain < 0 else MOVED

    def to_dict(self) -> dict[str, Any]:
        """Give plain values."""
        return {
            "kind": self.kind,
            "view": self.view,
            "axis": self.axis,
            "before": self.before,
            "after": self.after,
            "change": self.change,
            "tolerance": self.tolerance,
            "p": self.p,
            "least_p": self.least_p,
            "significant": self.significant,
            "beyond_tolerance": self.beyond,
            "state": self.state,
        }
