"""The table of a sweep's results on disk: one row a trial, in Parquet parts that appear whole.

``table.json`` says which columns there are, where the rows come from, and which folder holds them
as ``part-<number>.parquet``. Of rows with the same key the latest counts: the last one of the part
with the highest number. So merging parts, or a kill at any moment, loses no row and doubles none.

One process writes at a time; any number of others may read meanwhile.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from simtip.errors import InputError
from simtip.sweep.columns import Column, Row, checked
from simtip.sweep.durable import TEMPORARY, write_durably
from simtip.sweep.head import HEAD, ROWS_FOLDER, Head, read_head, rows_name_after
from simtip.sweep.parts import (
    as_table,
    frame_of,
    keys_of,
    latest_rows,
    merge_small,
    number_of,
    part_name,
    parts_in,
    write_part,
    write_rows,
)

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T")

OK = "ok"
"""Status of a trial that was measured."""

NUMBERS = ("trial", "repeat")
"""Columns that every row of a sweep fills."""

ATTEMPTS = 100
"""A reader lists the parts anew so often, at most, when one vanishes: they were merged."""

_PAUSE_S = 0.02


class Table:
    """A table of results on disk.

    Parameters
    ----------
    folder
        Where it is.

    Raises
    ------
    InputError
        There is no such folder, no table in it, or ``table.json`` is damaged or of another format.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._head = read_head(folder)
        self._tidied = False

    @classmethod
    def create(cls, folder: Path, columns: Sequence[Column], provenance: dict[str, Any]) -> Table:
        """Make an empty table.

        Parameters
        ----------
        folder
            Made if it is missing; what else is in it stays.
        columns
            In order; ``key``, ``trial`` and ``status`` have to be among them.
        provenance
            What JSON can hold about where the rows come from. ``trials``, if there is such a
            number, is told as the number of trials planned.

        Raises
        ------
        InputError
            The folder holds a table or rows already, or cannot be written.
        ValueError
            Columns are missing or have the same name, or the provenance is nothing for JSON.
        """
        head = Head(checked(columns), provenance)
        text = head.text()
        try:
            rows = folder / head.rows
            rows.mkdir(parents=True, exist_ok=True)
            if (folder / HEAD).exists() or any(rows.iterdir()):
                raise InputError(
                    "holds a table of results already", file=folder, remedy="name another folder"
                )
            write_durably(folder / HEAD, text)
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(
                f"cannot be written ({reason})", file=folder, remedy="name another folder"
            ) from error
        return cls(folder)

    @classmethod
    def open(cls, folder: Path) -> Table:
        """Open a table that is there; raises what the class itself does."""
        return cls(folder)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns, in order, as they were when the table was last read or written."""
        return self._head.columns

    @property
    def provenance(self) -> dict[str, Any]:
        """Where the rows come from, likewise."""
        return self._head.provenance

    def require(self, names: Iterable[str]) -> None:
        """Refuse a table that lacks columns.

        Raises
        ------
        InputError
            It does.
        """
        there = {column.name for column in self.columns}
        missing = [name for name in names if name not in there]
        if missing:
            raise InputError(
                f"lists no column {missing[0]}",
                file=self.folder / HEAD,
                field="columns",
                remedy="restore it, or run the sweep into a new folder",
            )

    def numbered(self) -> pd.DataFrame:
        """Read all rows as `frame` does, and refuse those that do not say which trial they are.

        Raises
        ------
        InputError
            As `frame`; or a row has no ``trial`` or ``repeat``.
        """
        self.require(NUMBERS)
        frame = self.frame()
        for name in NUMBERS:
            if frame[name].isna().any():
                raise InputError(
                    f"a row has no {name}",
                    file=self.folder / self._head.rows,
                    remedy="restore it, or run the sweep into a new folder",
                )
        return frame

    def append(self, rows: Sequence[Row]) -> None:
        """Add rows, as one part that appears whole.

        Parameters
        ----------
        rows
            By the columns' names; what a row lacks is missing. The key may not be missing.

        Raises
        ------
        TypeError
            A value does not fit its column, or there is no such column; nothing is written.
        OSError
            The disk is full, for example; nothing is left behind.
        """
        head = self._begin()
        if not rows:
            return
        table = as_table(rows, head)
        parts = self._parts(head)
        last = number_of(parts[-1]) if parts else 0
        write_part(self.folder / head.rows / part_name(last + 1), head.schema(), [table])

    def compact(self) -> None:
        """Merge small parts into larger ones if there are many; a kill at any moment is harmless.

        Raises
        ------
        OSError
            The disk is full, for example; the parts are as they were.
        InputError
            A part is damaged.
        """
        head = self._begin()
        merge_small(self._parts(head), head.schema())

    def rewrite(
        self,
        columns: Sequence[Column],
        rows: Iterable[Sequence[Row]],
        provenance: dict[str, Any],
    ) -> None:
        """Replace the whole table; a kill at any moment leaves the old one or the new one.

        Parameters
        ----------
        columns, provenance
            As for `create`.
        rows
            In batches, which are written as they come; may be made from this table's `batches`.

        Raises
        ------
        TypeError, OSError
            As for `append`; the old table stays.
        ValueError
            As for `create`; the old table stays.
        """
        old = self._begin()
        head = Head(checked(columns), provenance, rows_name_after(old.rows))
        text = head.text()
        try:
            write_rows(self.folder / head.rows, head, rows)
            write_durably(self.folder / HEAD, text)
        finally:
            self._head = self._tidy()  # table.json says which of the two is left over

    def frame(self) -> pd.DataFrame:
        """Read all rows, in order of ``trial``; the sweep may go on meanwhile.

        Returns
        -------
        frame
            Columns of int are ``Int64``, of float ``float64`` with NaN, of text ``string`` and of
            bool ``boolean``.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        return self._steady(frame_of)

    def keys(self) -> dict[str, str]:
        """Read the status of every row, by its key; the sweep may go on meanwhile.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        return self._steady(keys_of)

    def batches(self) -> Iterator[list[Row]]:
        """Give all rows, some thousand at a time, in the order they were written, for `rewrite`.

        Only for the process that writes: no other one may merge parts meanwhile.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        schema = self._head.schema()
        for table in latest_rows(self._parts(self._head), schema):
            yield table.to_pylist()

    def by_trial(self) -> dict[int, dict[str, Any]]:
        """Read all rows, by the trial's number, for the process that writes.

        Raises
        ------
        InputError
            A part is damaged or not of this table.
        """
        rows: Iterator[dict[str, Any]] = (row for batch in self.batches() for row in batch)
        return {int(row["trial"]): row for row in rows}

    def _parts(self, head: Head) -> list[Path]:
        """List the parts, for the process that writes."""
        folder = self.folder / head.rows
        try:
            folder.mkdir(exist_ok=True)  # somebody may have removed all rows, to compute them anew
        except FileExistsError as error:
            raise InputError(
                "is a file where the folder of the rows was",
                file=folder,
                remedy="remove it: what is missing will be computed anew",
            ) from error
        return parts_in(folder)

    def _begin(self) -> Head:
        """Read what the table is, before writing; the first time, remove what a kill left."""
        self._head = read_head(self.folder) if self._tidied else self._tidy()
        self._tidied = True
        return self._head

    def _tidy(self) -> Head:
        head = read_head(self.folder)
        for entry in self.folder.iterdir():
            if ROWS_FOLDER.fullmatch(entry.name) and entry.name != head.rows:
                shutil.rmtree(entry, ignore_errors=True)
        for folder in (self.folder, self.folder / head.rows):
            for entry in folder.glob(f"{TEMPORARY}*"):
                entry.unlink(missing_ok=True)
        return head

    def _steady(self, read: Callable[[Head, list[Path]], T]) -> T:
        """Read parts that another process may be merging or replacing."""
        for _ in range(ATTEMPTS):
            self._head = head = read_head(self.folder)
            try:
                result = read(head, parts_in(self.folder / head.rows))
            except (FileNotFoundError, NotADirectoryError):
                time.sleep(_PAUSE_S)
                continue
            # A replaced table's parts vanish one by one: what was read may be some of them.
            if read_head(self.folder).rows == head.rows:
                return result
        raise InputError(
            "parts of it are missing or vanish again and again",
            file=self.folder / self._head.rows,
            remedy="run the sweep again: what is missing will be computed anew",
        )
