"""The stored figures of a measurement: kept row by row, so that it can go on where it stopped."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from detector_conditions import Condition

Stored = dict[str, Any]


@dataclass
class Record:
    """All figures: older ones, and those of this measurement as they come.

    Attributes
    ----------
    head
        What is stored beside the rows.
    settings
        Of this measurement; a row that has the same belongs to it.
    keep
        Called with everything after every row.
    rows
        Figures by group and name of the condition, then by method.
    order
        Groups and names of all conditions.
    """

    head: Stored
    settings: Stored
    keep: Callable[[Stored], None]
    order: list[tuple[str, str]]
    rows: dict[tuple[str, str], Stored] = field(default_factory=dict)

    def has(self, condition: Condition, method: str) -> bool:
        """Say whether a row was measured in this measurement."""
        row = self.rows.get((condition.group, condition.name), {}).get(method, {})
        return row.get("settings") == self.settings

    def add(self, condition: Condition, method: str, found: Stored) -> None:
        """Put a row in the place of an older one, and keep all."""
        methods = self.rows.setdefault((condition.group, condition.name), {})
        methods[method] = {**found, "settings": self.settings}
        self.keep(self.stored())

    def stored(self) -> Stored:
        """Give everything, conditions in their order."""
        entries = [
            {"group": group, "name": name, "methods": self.rows[group, name]}
            for group, name in self.order
            if self.rows.get((group, name))
        ]
        return {**self.head, **self.settings, "conditions": entries}


def record(
    old: Stored,
    head: Stored,
    settings: Stored,
    every: Sequence[Condition],
    keep: Callable[[Stored], None],
    *,
    resume: bool,
) -> Record:
    """Begin a measurement, or go on with the one that was interrupted.

    Parameters
    ----------
    old
        What is stored; empty if there is nothing.
    head, settings
        See `Record`; the time of its beginning is added to the settings.
    every
        All conditions.
    keep
        See `Record`.
    resume
        Whether the stored measurement goes on: its rows with the same settings are not measured
        again.
    """
    now = dt.datetime.now(dt.UTC).isoformat(timespec="microseconds")
    begun = old.get("begun_utc", now) if resume else now
    rows = {(one["group"], one["name"]): dict(one["methods"]) for one in old.get("conditions", [])}
    order = [(condition.group, condition.name) for condition in every]
    return Record(head, {**settings, "begun_utc": begun}, keep, order, rows)
