"""A CSV file as rows of text with their line numbers; nothing in it is run or guessed at."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from simtip.errors import InputError
from simtip.input_file import read_bytes

MAX_BYTES = 64 * 1024**2
MAX_ROWS = 1_000_000
DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs"}


@dataclass(frozen=True)
class Row:
    """The cells of a row, blanks around them taken off, and the line that it begins on."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Sheet:
    """A header and the rows below it, as long as the header; blank lines are left out."""

    file: Path
    delimiter: str
    header: Row
    rows: tuple[Row, ...]


def read_sheet(path: str | Path) -> Sheet:
    """Read a CSV file: UTF-8, a header, cells between commas, semicolons or tabs.

    The delimiter is the one of the three that splits the header into most cells.

    Raises
    ------
    InputError
        The file cannot be read, is no such text, has no rows, or a row has more or fewer cells
        than the header.
    """
    file = Path(path)
    text = _text(file)
    first = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = max(DELIMITERS, key=first.count)  # commas if there is none of the three
    rows = list(_rows(text, delimiter, file))
    if len(rows) < 2:
        raise InputError(
            "has a header at most, and no row", file=file, line=1, remedy="add the measurements"
        )
    header, *body = rows
    sheet = Sheet(file, delimiter, header, tuple(_fitted(row, header, file) for row in body))
    if len(body) > MAX_ROWS:
        raise InputError(
            f"has {len(body)} rows, more than the limit of {MAX_ROWS}",
            file=file,
            remedy="is it the right file?",
        )
    return sheet


def _text(file: Path) -> str:
    data = read_bytes(file, MAX_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            "is not UTF-8 text",
            file=file,
            line=data[: error.start].count(b"\n") + 1,
            remedy="save it as CSV, UTF-8",
        ) from None
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise InputError("is no text", file=file, line=line, remedy="save it as CSV, UTF-8")
    return text


def _rows(text: str, delimiter: str, file: Path) -> Iterator[Row]:
    # newline="": the reader itself knows a line's end from one inside quotes.
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    line = 1
    try:
        for cells in reader:
            stripped = tuple(cell.strip() for cell in cells)
            if any(stripped):
                yield Row(line, stripped)
            line = reader.line_num + 1
    except csv.Error as error:
        raise InputError(
            f"is no CSV ({error})", file=file, line=line, remedy="check its quotes"
        ) from None


def _fitted(row: Row, header: Row, file: Path) -> Row:
    """Give the row with as many cells as the header; empty cells may be over at its end."""
    count = len(header.cells)
    if len(row.cells) < count or any(row.cells[count:]):
        raise InputError(
            f"has {len(row.cells)} cells, and the header {count}",
            file=file,
            line=row.line,
            remedy="give every row one cell a column, with a decimal point in numbers",
        )
    return Row(row.line, row.cells[:count])
