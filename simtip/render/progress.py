"""Progress of work whose amount is found out on the way."""

from __future__ import annotations

from simtip.render.view import Progress


class Tally:
    """Counts samples done against samples planned; never runs backwards."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._planned = 0
        self._done = 0
        self._shown = 0.0

    def plan(self, samples: int) -> None:
        """Add work that has come to light."""
        self._planned += samples

    def add(self, samples: int) -> None:
        """Report work done."""
        self._done += samples
        self._shown = max(self._shown, min(1.0, self._done / max(self._planned, 1)))
        if self._progress is not None:
            self._progress(self._shown)
