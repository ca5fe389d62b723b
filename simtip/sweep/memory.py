"""What a process keeps in memory of what it made or read."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

Row = dict[str, object]
Made = TypeVar("Made")


class Memory(OrderedDict[str, Any]):
    """The last few things that were made, by key."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def give(self, key: str, make: Callable[[], Made]) -> Made:
        """Give what is kept under a key, or make it."""
        if key in self:
            self.move_to_end(key)
        else:
            while len(self) >= self._most:
                self.popitem(last=False)
            self[key] = make()
        found: Made = self[key]
        return found


class Records:
    """What is known of a log of measurements."""

    def __init__(self) -> None:
        self.found: dict[str, Row] = {}
        self.read_bytes = 0

    def take_in(self, lines: list[str], read_bytes: int) -> None:
        """Take in what has been added; of damaged lines nothing."""
        self.read_bytes = read_bytes
        for line in lines:
            with suppress(ValueError):
                said = json.loads(line)
                if isinstance(said, dict) and isinstance(said.get("record"), dict):
                    self.found[str(said.get("key"))] = said["record"]
