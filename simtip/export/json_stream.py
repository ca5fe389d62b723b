"""JSON files that grow entry by entry, and are valid JSON once closed."""

from __future__ import annotations

import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self


class _Growing:
    """A file with brackets around entries, one a line."""

    BRACKETS = "[]"

    def __init__(self, path: Path) -> None:
        self._path = path
        self._count = 0

    def __enter__(self) -> Self:
        """Open it."""
        self._stream = self._path.open("w", encoding="utf-8", newline="\n")
        self._stream.write(self.BRACKETS[0])
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        with self._stream:
            if kind is None:
                self._stream.write(f"\n{self.BRACKETS[1]}\n")

    def _add(self, text: str) -> None:
        self._stream.write(f"{',' if self._count else ''}\n{text}")
        self._count += 1


class JsonArray(_Growing):
    """An array on disk."""

    def add(self, value: Any) -> None:
        """Add an element."""
        self._add(json.dumps(value, allow_nan=False))


class JsonObject(_Growing):
    """An object on disk."""

    BRACKETS = "{}"

    def add(self, name: str, value: Any) -> None:
        """Add a member, whose name is none that was there."""
        self._add(f"{json.dumps(name)}: {json.dumps(value, allow_nan=False)}")
