"""A table of results as comma-separated text."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from simtip.sweep.frames import plain

if TYPE_CHECKING:
    import pandas as pd

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""A spreadsheet takes text that begins so for a formula, which may do harm."""

CHUNK_ROWS = 10_000


def to_csv(frame: pd.DataFrame) -> str:
    """Give a table as comma-separated text, RFC 4180.

    Numbers are the shortest that read back to the same bits, missing values empty. A text that a
    spreadsheet would take for a formula gets an apostrophe in front.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow([cell_text(str(name)) for name in frame.columns])
    for start in range(0, len(frame), CHUNK_ROWS):
        chunk = frame.iloc[start : start + CHUNK_ROWS]
        writer.writerows(zip(*(map(cell_text, plain(chunk[name])) for name in chunk), strict=True))
    return out.getvalue()


def cell_text(value: object) -> str:
    """Give a cell as text, before it is quoted."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(value))
    text = str(value)
    return f"'{text}" if isinstance(value, str) and text.startswith(FORMULA) else text
