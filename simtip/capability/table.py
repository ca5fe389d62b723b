"""Measurements from a CSV file: which columns there are, and what is wrong with them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simtip.capability.csv_rows import Row, Sheet, read_sheet
from simtip.capability.interval import Array
from simtip.errors import InputError

NUMBERS = ("reference", "measured")
LABELS = ("part", "operator", "trial", "run")
COLUMNS = (*NUMBERS, *LABELS)
"""What simtip calls the columns; only ``measured`` has to be there."""

LARGEST = 1e30
"""Larger numbers are none that anybody measured, and their fourth powers would overflow."""

PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class Table:
    """Measurements, a row each.

    Attributes
    ----------
    file, lines
        Where they come from: the line of each row.
    measured, reference
        (n,) numbers in the file's own unit; the reference is None if there is no such column.
    labels
        By the names in `LABELS`, of the columns that are there: (n,) texts.
    headers
        What the file calls each column that is there.
    """

    file: Path
    lines: tuple[int, ...]
    measured: Array
    reference: Array | None
    labels: Mapping[str, tuple[str, ...]]
    headers: Mapping[str, str]

    def error(self, problem: str, field: str, row: int = 0, *, remedy: str) -> InputError:
        """Give an error about a column, and a row counted from 0, with its line."""
        return InputError(
            problem,
            file=self.file,
            line=self.lines[row],
            field=self.headers.get(field, field),
            remedy=remedy,
        )

    def keys(self, *names: str) -> list[tuple[str, ...]]:
        """Give what each row has in those of the label columns that are there, (n,)."""
        there = [self.labels[name] for name in names if name in self.labels]
        return list(zip(*there, strict=True)) if there else [() for _ in self.lines]


def read_table(path: str | Path, columns: Mapping[str, str] | None = None) -> Table:
    """Read measurements from a CSV file.

    Parameters
    ----------
    path
        The file; `read_sheet` says of what form.
    columns
        The file's own names of columns, by simtip's in `COLUMNS`; without one, the file's is
        simtip's, in small or capital letters.

    Raises
    ------
    InputError
        The file cannot be read; a column, or a value in one, is missing; a number is none, not
        finite or written with a decimal comma; one trial of a part and operator is there twice.
    """
    sheet = read_sheet(path)
    places = _places(sheet, columns or {})
    numbers = {
        name: np.array([_number(row, places[name], sheet) for row in sheet.rows])
        for name in NUMBERS
        if name in places
    }
    labels = {
        name: tuple(_label(row, places[name], sheet) for row in sheet.rows)
        for name in LABELS
        if name in places
    }
    table = Table(
        file=sheet.file,
        lines=tuple(row.line for row in sheet.rows),
        measured=numbers["measured"],
        reference=numbers.get("reference"),
        labels=labels,
        headers={name: sheet.header.cells[place] for name, place in places.items()},
    )
    _refuse_repeats(table)
    return table


def _places(sheet: Sheet, columns: Mapping[str, str]) -> dict[str, int]:
    """Find the columns that are there."""
    places: dict[str, int] = {}
    for name in COLUMNS:
        wanted = columns.get(name, name)
        place = _place(sheet, name, wanted)
        if place is not None:
            places[name] = place
        elif name in columns or name == "measured":
            raise InputError(
                f"there is no column {wanted[:80]!r}",
                file=sheet.file,
                line=sheet.header.line,
                field=name,
                remedy=f"the header has {_shown(sheet.header.cells)}: say --column {name}=HEADER",
            )
    for name, place in places.items():
        for other, same in places.items():
            if other != name and place == same:
                raise InputError(
                    f"is said to be both {other} and {name}",
                    file=sheet.file,
                    line=sheet.header.line,
                    field=sheet.header.cells[place],
                    remedy="name another header by --column",
                )
    return places


def _place(sheet: Sheet, name: str, wanted: str) -> int | None:
    cells = sheet.header.cells
    exact = [k for k, cell in enumerate(cells) if cell == wanted]
    alike = [k for k, cell in enumerate(cells) if cell.casefold() == wanted.casefold()]
    found = exact or alike
    if len(found) > 1:
        raise InputError(
            f"there are {len(found)} columns {wanted[:80]!r}",
            file=sheet.file,
            line=sheet.header.line,
            field=name,
            remedy="rename or drop all but one",
        )
    return found[0] if found else None


def _shown(cells: Sequence[str]) -> str:
    names = ", ".join(repr(cell[:40]) for cell in cells[:12])
    return f"{names}, ..." if len(cells) > 12 else names


def _number(row: Row, place: int, sheet: Sheet) -> float:
    text = row.cells[place]
    problem, remedy = f"{text[:80]!r} is no number", "write a plain number, as 1.25"
    if not text:
        problem, remedy = "the value is missing", "fill it in or drop the row"
    elif PLAIN.fullmatch(text):
        number = float(text)
        if abs(number) <= LARGEST:
            return number
        problem = f"{text[:80]!r} is larger than {LARGEST:g}"
    elif DECIMAL_COMMA.fullmatch(text):
        problem = f"{text[:80]!r} has a decimal comma"
        remedy = "write a decimal point"
    elif _not_finite(text):
        problem, remedy = f"{text[:80]!r} is not finite", "drop the row"
    raise InputError(
        problem,
        file=sheet.file,
        line=row.line,
        field=sheet.header.cells[place],
        remedy=remedy,
    )


def _not_finite(text: str) -> bool:
    try:
        return not math.isfinite(float(text))
    except ValueError:
        return False


def _label(row: Row, place: int, sheet: Sheet) -> str:
    if not row.cells[place]:
        raise InputError(
            "the value is missing",
            file=sheet.file,
            line=row.line,
            field=sheet.header.cells[place],
            remedy="fill it in or drop the row",
        )
    return row.cells[place]


def _refuse_repeats(table: Table) -> None:
    """Refuse two rows of one part, operator and trial (and run)."""
    if not {"part", "trial"} <= table.labels.keys():
        return
    seen: dict[tuple[str, ...], int] = {}
    for row, key in enumerate(table.keys("part", "operator", "trial", "run")):
        before = seen.setdefault(key, row)
        if before != row:
            names = [name for name in ("part", "operator", "trial", "run") if name in table.labels]
            said = ", ".join(
                f"{name} {value[:40]!r}" for name, value in zip(names, key, strict=True)
            )
            raise table.error(
                f"{said} is on line {table.lines[before]} already",
                "trial",
                row,
                remedy="number the trials of a part, or drop one of the two rows",
            )
