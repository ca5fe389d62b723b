"""Comma-separated text on disk that grows row by row."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from simtip.sweep.csv_text import cell_text


class CsvRows:
    """A table that takes rows.

    Parameters
    ----------
    writer
        Of `csv`.
    columns
        Names, in order.
    """

    def __init__(self, writer: Any, columns: Sequence[str]) -> None:
        self._writer, self._columns = writer, columns
        writer.writerow([cell_text(name) for name in columns])

    def add(self, row: Mapping[str, object]) -> None:
        """Add a row by its columns' names; what it lacks is empty.

        Raises
        ------
        KeyError
            There is no such column.
        """
        strangers = row.keys() - set(self._columns)
        if strangers:
            raise KeyError(min(strangers))
        self._writer.writerow([cell_text(row.get(name)) for name in self._columns])


@contextmanager
def csv_rows(path: Path, columns: Sequence[str]) -> Iterator[CsvRows]:
    """Begin a table, RFC 4180, UTF-8; numbers are the shortest that read back to the same bits."""
    # Names of folders may hold what is no Unicode.
    with path.open("w", encoding="utf-8", errors="backslashreplace", newline="") as stream:
        yield CsvRows(csv.writer(stream, lineterminator="\r\n"), columns)
