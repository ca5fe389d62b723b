"""The pairs that a test has used: those of which pictures are drawn, should it fail."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

import pytest

from simtip.pytest_plugin.stashed import USED

if TYPE_CHECKING:
    from simtip.measure import Measurement
    from simtip.pytest_plugin.pair import Pair

MOST_PICTURES = 8
"""Of one test; images of more pairs are not kept in memory, either."""

Shown = OrderedDict["Pair", "Measurement | None"]


class Used:
    """Remembers the last few pairs, and the first few that failed an assertion of simtip's."""

    def __init__(self) -> None:
        self._last: Shown = OrderedDict()
        self._failed: Shown = OrderedDict()
        self.left_out = 0
        """Pairs that failed and are not kept."""

    def note(self, pair: Pair, measurement: Measurement | None = None) -> None:
        """Take note of a pair that was given out, or of what was measured on it."""
        self._last[pair] = measurement
        self._last.move_to_end(pair)
        while len(self._last) > MOST_PICTURES:
            self._last.popitem(last=False)

    def note_failure(self, pair: Pair, measurement: Measurement) -> None:
        """Take note of a pair that failed."""
        if len(self._failed) < MOST_PICTURES:
            self._failed[pair] = measurement
        else:
            self.left_out += 1

    def take(self) -> tuple[Shown, int]:
        """Give the pairs to draw and how many more failed, and forget them.

        Those that failed; if none did, so that it was the test's own assertion that failed, the
        last ones.
        """
        taken, left_out = (self._failed or self._last), self.left_out
        self._last, self._failed, self.left_out = OrderedDict(), OrderedDict(), 0
        return taken, left_out


def used_by(request: pytest.FixtureRequest) -> Used:
    """Give the record of a test; what an earlier run of it has left is removed."""
    item: pytest.Item = request.node
    if USED not in item.stash:
        from simtip.pytest_plugin.pictures import remove_old

        remove_old(item)
        item.stash[USED] = Used()
    return item.stash[USED]
