"""A table of results as bytes that the page's script reads, column by column.

A head in JSON (its length first, 4 bytes, little-endian) says which columns there are; then come
their numbers, each column beginning at a multiple of 8 bytes. Columns of few different values hold
the number of the value.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.sweep.compact import compact
from simtip.sweep.frames import kind_of, plain

if TYPE_CHECKING:
    import pandas as pd

MISSING = "\N{EN DASH}"

MOST_CODED = 2000
"""Different numbers of a factor; of more, the numbers themselves are kept."""

ALIGNED = 8


@dataclass(frozen=True, eq=False)
class Packed:
    """One column.

    Attributes
    ----------
    said
        What the head tells of it.
    cells
        (n,) numbers.
    """

    said: dict[str, Any]
    cells: NDArray[Any]


def packed(columns: Sequence[Packed], rows: int) -> bytes:
    """Give a table of so many rows."""
    length = 0
    for _ in range(3):  # the head tells where columns begin, which depends on the head
        head = _head(columns, rows, length)
        length = len(head)
    parts = [struct.pack("<I", len(head)), head]
    at = 4 + len(head)
    for column in columns:
        start = _aligned(at)
        data = np.ascontiguousarray(column.cells).tobytes()
        parts += [b"\0" * (start - at), data]
        at = start + len(data)
    return b"".join(parts)


def _head(columns: Sequence[Packed], rows: int, length: int) -> bytes:
    at = _aligned(4 + _aligned(length))
    told = []
    for column in columns:
        told.append({**column.said, "type": column.cells.dtype.str[1:], "offset": at})
        at = _aligned(at + column.cells.nbytes)
    text = json.dumps({"rows": rows, "columns": told}, allow_nan=False).encode()
    return text + b" " * (_aligned(len(text)) - len(text))


def _aligned(at: int) -> int:
    return -(-at // ALIGNED) * ALIGNED


def numbers(name: str, column: pd.Series[Any], unit: str = "", *, whole: bool = False) -> Packed:
    """Pack a column of measured numbers, in single precision; whole ones exactly."""
    values = column.to_numpy(dtype=np.float64, na_value=math.nan)
    values = np.where(np.isfinite(values), values, math.nan)
    said = {"name": name, "unit": unit, "whole": whole, "filled": bool((~np.isnan(values)).any())}
    fits = np.nanmax(np.abs(values), initial=0) < np.finfo(np.float32).max
    return Packed(said, values.astype("<f4" if fits and not whole else "<f8"))


def codes(name: str, column: pd.Series[Any], always: Sequence[str] = ()) -> Packed:
    """Pack a column by its different values: sorted, the missing one last.

    Parameters
    ----------
    name, column
        What is packed.
    always
        Texts that are levels even if no row has them.
    """
    numeric = kind_of(column) in {"int", "float"}
    if numeric and column.nunique() > MOST_CODED:
        return numbers(name, column, whole=True)
    cells = plain(column)
    known = _known(cells, always)
    place: dict[Any, int] = {cell: k for k, cell in enumerate(known)}
    levels = _in_words(known)
    said: dict[str, Any] = {"name": name, "unit": "", "levels": levels, "missing": None}
    said["filled"] = bool(known)
    if any(cell is None for cell in cells):
        place[None] = said["missing"] = len(known)
        said["levels"] = [*levels, MISSING]
    if known and all(isinstance(cell, bool | int | float) for cell in known):
        values = [float(cell) if math.isfinite(cell) else None for cell in known]
        said["numbers"] = values + [None] * (len(said["levels"]) - len(known))
    kind = "<u1" if len(place) < 1 << 8 else "<u2" if len(place) < 1 << 16 else "<u4"
    return Packed(said, np.array([place[cell] for cell in cells], dtype=kind))


def levels_of(column: pd.Series[Any]) -> tuple[NDArray[np.intp], list[str]]:
    """Give the level of every row (n,), and what the levels are called; missing is the last."""
    cells = plain(column)
    known = _known(cells)
    place: dict[Any, int] = {cell: k for k, cell in enumerate(known)}
    missing = [MISSING] if any(cell is None for cell in cells) else []
    place[None] = len(known)
    return np.array([place[cell] for cell in cells], np.intp), [*_in_words(known), *missing]


def _known(cells: Sequence[Any], always: Sequence[str] = ()) -> list[Any]:
    return sorted({cell for cell in cells if cell is not None} | set(always), key=_order)


def _order(cell: Any) -> tuple[bool, Any]:
    return (isinstance(cell, str), cell)


def _in_words(known: Sequence[Any]) -> list[str]:
    """Write values so that each differs from the others; numbers with three digits at least."""
    for digits in range(3, 17):
        said = [_said(cell, digits) for cell in known]
        if len(set(said)) == len(said):
            return said
    return [str(cell) for cell in known]


def _said(cell: Any, digits: int) -> str:
    if isinstance(cell, bool):
        return str(cell).lower()
    if isinstance(cell, float):
        return f"{cell:.{digits}g}" if digits < 16 and abs(cell) < 10**digits else f"{cell:.6g}"
    return compact(str(cell))
