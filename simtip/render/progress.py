"""Progress of work whose amount is found out on the way."""

from __future__ import annotations

from simtip.render.view import Progress

ALMOST = 0.99
"""As far as it goes before the end: more work may come to light."""


class Tally:
    """Counts samples done against samples planned; never runs backwards."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._planned = 0
        self._expected = 0
        self._done = 0
        self._shown = 0.0

    def expect(self, samples: int) -> None:
        """Guess at work that is still to be planned."""
        self._expected += samples

    def plan(self, samples: int) -> None:
        """Add work that has come to light; it is taken off what was expected."""
        self._planned += samples
        self._expected = max(self._expected - samples, 0)

    def add(self, samples: int) -> None:
        """Report work done."""
        self._done += samples
        self._show(min(ALMOST, self._done / max(self._planned + self._expected, 1)))

    def finish(self) -> None:
        """Report that all is done."""
        self._show(1.0)

    def _show(self, share: float) -> None:
        self._shown = max(self._shown, share)
        if self._progress is not None:
            self._progress(self._shown)
