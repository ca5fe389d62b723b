"""Recordings read back by Rerun's own reader."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

from rerun.chunk import RrdReader


class Recorded:
    """What a file holds: by entity and component, values by trial; None is static."""

    def __init__(self, file: Path) -> None:
        reader = RrdReader(file)
        assert len(reader.recordings()) == 1
        self.blueprints = len(reader.blueprints())
        self._found: dict[tuple[str, str], dict[int | None, Any]] = defaultdict(dict)
        for chunk in reader.stream():
            columns = chunk.to_record_batch().to_pydict()
            trials = columns.get("trial") or [None] * chunk.num_rows
            for name, values in columns.items():
                if ":" in name:
                    one = self._found[str(chunk.entity_path), name.partition(":")[2]]
                    one |= {t: v for t, v in zip(trials, values, strict=True) if v is not None}

    def entities(self) -> set[str]:
        return {entity for entity, _ in self._found}

    def at(self, entity: str, component: str, trial: int | None = 0) -> Any:
        """Give the latest value up to a trial."""
        values = self._found[entity, component]
        if trial is None:
            return values[None]
        times = [time for time in values if time is not None and time <= trial]
        return values[max(times)]

    def trials(self, entity: str, component: str) -> list[int | None]:
        return sorted(self._found[entity, component], key=lambda time: -1 if time is None else time)
