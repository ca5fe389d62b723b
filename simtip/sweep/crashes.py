"""What becomes of trials whose process died: which are worked out again, and which is to blame."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from simtip.sweep.note import Last

DIED, TIMED_OUT = "worker_died", "timed_out"
"""Statuses of trials that end their process."""

FROM_OUTSIDE = {"SIGKILL", "SIGTERM", "SIGHUP", "SIGINT", "SIGQUIT", "SIGXCPU"}
"""Signals that others send: a user, a batch system, the kernel when there is no memory left."""

MOST_KILLS = 3
"""A trial during which a process was killed from outside so often is given up."""


@dataclass(frozen=True)
class Verdict:
    """What is to be done.

    Attributes
    ----------
    again
        Trials of jobs to hand out.
    blamed
        The trial that ended its process: its number, status and reason; None if none is known to.
    """

    again: list[list[int]]
    blamed: tuple[int, str, str] | None = None


class Crashes:
    """Remembers which trials were interrupted, and how often.

    Parameters
    ----------
    time_limit_s
        Of a trial.
    """

    def __init__(self, time_limit_s: float) -> None:
        self._limit = time_limit_s
        self._kills: Counter[int] = Counter()

    def judge(self, trials: Sequence[int], last: Last | None, code: int | None) -> Verdict:
        """Say what becomes of the trials of a job whose process died.

        Parameters
        ----------
        trials
            Of the job.
        last
            What its note says of the one at work.
        code
            How the process ended, below 0 by which signal; None where a cluster has already tried
            several times.
        """
        if last is None or last.trial not in trials:
            if len(trials) > 1:
                half = len(trials) // 2
                return Verdict([list(trials[:half]), list(trials[half:])])
            last = Last(trials[0], timed_out=False)
        at = trials.index(last.trial)
        others = [part for part in (list(trials[:at]), list(trials[at + 1 :])) if part]
        if last.timed_out:
            reason = f"its process took longer than {self._limit:g} s"
            return Verdict(others, (last.trial, TIMED_OUT, reason))
        ended = _ended(code)
        if ended in FROM_OUTSIDE:
            self._kills[last.trial] += 1
            if self._kills[last.trial] < MOST_KILLS:
                return Verdict([*others, [last.trial]])
            reason = (
                f"its process was killed {MOST_KILLS} times ({ended}): no memory, or from outside"
            )
            return Verdict(others, (last.trial, DIED, reason))
        return Verdict(
            others, (last.trial, DIED, f"its process died ({ended}): a crash in the detector")
        )


def _ended(code: int | None) -> str:
    """Say how a process ended."""
    if code is None:
        return "again and again"
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
