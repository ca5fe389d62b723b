"""How far a sweep is, and who is told."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from simtip.sweep.speeds import Spent


@dataclass
class Tally:
    """How far a sweep is.

    Attributes
    ----------
    total, before, done
        Trials: of the plan, found done, done now.
    failed
        By status, of those done now.
    counts
        How often each stage was worked out now.
    crashes
        Worker processes that died.
    spent
        Time in stages.
    """

    total: int
    before: int = 0
    done: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    counts: Counter[str] = field(default_factory=Counter)
    crashes: int = 0
    spent: Spent = field(default_factory=Spent)
    started: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Wall time so far."""
        return time.perf_counter() - self.started


Report = Callable[[Tally], None]
