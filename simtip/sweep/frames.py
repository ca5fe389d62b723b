"""What the columns of a frame of results hold, in plain words and plain values."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


def plain(column: pd.Series[Any]) -> list[Any]:
    """Give a column's values as plain Python ones; missing is None."""
    cells = column.astype(object)
    return list(cells.where(column.notna(), None))


def kind_of(column: pd.Series[Any]) -> str:
    """Give a column's kind: int, float, text or bool."""
    kinds = {"b": "bool", "i": "int", "f": "float"}
    return kinds.get(getattr(column.dtype, "kind", "O"), "text")


def nearest(name: str, known: Iterable[str]) -> str:
    """Say which known names were probably meant, or list them all."""
    names = list(known)
    close = [known for known in names if name and name in known]
    close += [near for near in difflib.get_close_matches(name, names, n=3) if near not in close]
    if 0 < len(close) <= 5:
        return f"did you mean {' or '.join(map(repr, close))}?"
    return f"known: {', '.join(names)}"


def require(name: str, frame: pd.DataFrame, option: str) -> None:
    """Refuse a column that is not there.

    Raises
    ------
    InputError
        It is not; it names the option that asked for it.
    """
    if name not in frame.columns:
        raise InputError(
            f"there is no column {name[:200]!r}",
            field=option,
            remedy=nearest(name, map(str, frame.columns)),
        )


def marks(column: pd.Series[Any]) -> NDArray[np.bool_]:
    """Give true and false alone; missing is false."""
    return np.asarray(column.fillna(value=False), dtype=np.bool_)
