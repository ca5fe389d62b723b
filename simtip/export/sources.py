"""Where each pair of an export comes from, beside it: ``sources.csv``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from simtip.export.csv_stream import CsvRows, csv_rows

SOURCES = "sources.csv"
COLUMNS = ("left", "right", "source", "label")


@contextmanager
def source_rows(folder: Path) -> Iterator[CsvRows]:
    """Begin the list: both images' files, relative to the folder, and what they were made of."""
    with csv_rows(folder / SOURCES, COLUMNS) as rows:
        yield rows
