"""Is a detector slower? Its time over the reference operation's, now and as recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from simtip.regress.baseline import TimedCondition
from simtip.regress.change import BETTER, SAME, UNTOLD, WORSE
from simtip.regress.line import Line
from simtip.regress.timing import Ratio

TIME = "time"

SIGMAS = 4.0
"""By which the ratio has to be off 1, besides being beyond its tolerance."""

SYSTEMATIC = 0.08
"""Standard error of a ratio's logarithm, at least: caches, clock rates, what else runs."""

LOOK_AGAIN = 1.25
"""A ratio above this is measured once more, and the lower of the two counts."""


@dataclass(frozen=True)
class TimeChange:
    """A detector's time, compared.

    Attributes
    ----------
    recorded, now
        Of each condition, in the same order; None now if it did not come to an end.
    ratio
        Geometric mean of now over recorded; None if there is none.
    error
        Standard error of its logarithm.
    tolerance
        Least ratio that counts.
    """

    recorded: Sequence[TimedCondition]
    now: Sequence[Ratio | None]
    ratio: float | None
    error: float
    tolerance: float

    @property
    def state(self) -> str:
        """What is said of it."""
        if self.ratio is None:
            return UNTOLD
        sure = abs(math.log(self.ratio)) > SIGMAS * self.error
        if self.ratio > self.tolerance:
            return WORSE if sure else UNTOLD
        return BETTER if self.ratio < 1 / self.tolerance and sure else SAME

    def lines(self) -> list[Line]:
        """Say it in words, if there is something to say."""
        if self.state == SAME:
            return []
        if self.ratio is None:
            text = "time: the detector did not come to an end when it was timed"
        else:
            word = "slower" if self.ratio > 1 else "faster"
            times = self.ratio if self.ratio > 1 else 1 / self.ratio
            text = f"{word}: {times:.1f} x the time"
            if self.state == UNTOLD:
                text += ", but the machine was too busy to be sure; check again when it is quiet"
        return [Line(self.state, TIME, (), text)]

    def to_dict(self) -> dict[str, Any]:
        """Give plain values."""
        return {
            "state": self.state,
            "ratio": self.ratio,
            "log_error": self.error,
            "tolerance": self.tolerance,
            "conditions": [
                {
                    "case": was.case,
                    "condition": was.condition,
                    "before": was.ratio,
                    "before_scatter": was.scatter,
                    "after": None if now is None else now.ratio,
                    "after_scatter": None if now is None else now.scatter,
                }
                for was, now in zip(self.recorded, self.now, strict=True)
            ],
        }


def time_change(
    recorded: Sequence[TimedCondition],
    measure: Callable[[TimedCondition], Ratio | None],
    tolerance: float,
) -> tuple[TimeChange, list[Ratio | None]]:
    """Measure a detector's time and compare it.

    Parameters
    ----------
    recorded
        Times to compare with.
    measure
        Measures one of them now; None if it did not come to an end.
    tolerance
        Least ratio that counts.

    Returns
    -------
    change, now
        What is said of it, and the ratios now.
    """
    now = [measure(one) for one in recorded]
    first = _change(recorded, now, tolerance)
    if first.ratio is not None and first.ratio > LOOK_AGAIN:
        again = [measure(one) for one in recorded]
        now = [_lower(one, other) for one, other in zip(now, again, strict=True)]
    return _change(recorded, now, tolerance), now


def _lower(one: Ratio | None, other: Ratio | None) -> Ratio | None:
    if one is None or other is None:
        return one or other
    return one if one.ratio <= other.ratio else other


def _change(
    recorded: Sequence[TimedCondition], now: Sequence[Ratio | None], tolerance: float
) -> TimeChange:
    both = [(was, one) for was, one in zip(recorded, now, strict=True) if one is not None]
    if not both:
        return TimeChange(recorded, now, None, math.inf, tolerance)
    logs = [math.log(one.ratio / was.ratio) for was, one in both]
    squares = [was.scatter**2 + one.scatter**2 + SYSTEMATIC**2 for was, one in both]
    error = math.sqrt(sum(squares)) / len(both)
    return TimeChange(recorded, now, math.exp(sum(logs) / len(logs)), error, tolerance)
