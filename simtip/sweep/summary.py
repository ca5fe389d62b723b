"""A table of results filtered, grouped and written as text; nothing here reads or writes files."""

from __future__ import annotations

import csv
import difflib
import io
import math
import operator
import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

OK = "ok"
"""Status of a trial that was measured."""

CONDITION = re.compile(r"\s*(.*?)\s*(==|!=|<=|>=|<|>)\s*(.*?)\s*", re.DOTALL)
OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}

Values = NDArray[np.float64]

STATISTICS: dict[str, Callable[[Values], float]] = {
    "mean": lambda x: float(np.mean(x)),
    "std": lambda x: float(np.std(x, ddof=1)) if len(x) > 1 else math.nan,
    "rms": lambda x: float(np.sqrt(np.mean(x**2))),
    "median": lambda x: float(np.median(x)),
    "min": lambda x: float(np.min(x)),
    "max": lambda x: float(np.max(x)),
    "p05": lambda x: float(np.percentile(x, 5)),
    "p95": lambda x: float(np.percentile(x, 95)),
    "mean_abs": lambda x: float(np.mean(np.abs(x))),
}
"""What ``column:how`` may ask for, besides ``count``; of one value at least.

``std`` is the sample's, over n - 1; percentiles are interpolated linearly.
"""

COUNT = "count"
RATE = "detection_rate"

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""A spreadsheet takes text that begins so for a formula, which may do harm."""

CHUNK_ROWS = 10_000


def filtered(frame: pd.DataFrame, conditions: Iterable[str]) -> pd.DataFrame:
    """Keep the rows that meet all conditions.

    Parameters
    ----------
    frame
        As `Table.frame` gives it.
    conditions
        Each ``column OP value``, OP being one of ``== != < <= > >=``; the value is read as the
        column's kind. A missing value meets no condition.

    Raises
    ------
    InputError
        A condition cannot be read, or there is no such column.
    """
    keep = np.ones(len(frame), dtype=np.bool_)
    for condition in conditions:
        keep &= _met(frame, condition)
    return frame.loc[keep].reset_index(drop=True)


def grouped(frame: pd.DataFrame, by: Sequence[str], stats: Sequence[str]) -> pd.DataFrame:
    """Give statistics of the rows that agree in some columns.

    Parameters
    ----------
    frame
        As `Table.frame` gives it.
    by
        Those columns; none makes one group of all rows. A missing value is a value of its own.
    stats
        ``detection_rate`` (share of rows with status ok), ``count`` (of rows), or ``column:how``
        with how one of `STATISTICS` or ``count``, over the rows that have a number there.

    Returns
    -------
    frame
        One row a group, sorted by the columns `by`, missing last: these, ``n`` (rows of the
        group) and the statistics under the names they were asked by. NaN where no row has a
        number.

    Raises
    ------
    InputError
        There is no such column or statistic, or it needs numbers and the column is text.
    """
    import pandas as pd

    by, stats = list(dict.fromkeys(by)), list(dict.fromkeys(stats))
    for name in by:
        _require(name, frame, "--by")
    measures = {stat: _measure(stat, frame) for stat in stats}
    firsts, groups = _groups(frame, by)
    told: dict[str, Any] = {"n": pd.array([len(group) for group in groups], dtype="Int64")}
    for stat, (values, figure) in measures.items():
        told[stat] = [figure(values[group]) for group in groups]
        kind = "Int64" if stat.endswith(COUNT) else "float64"
        told[stat] = pd.array(told[stat], dtype=kind) if groups else pd.Series(dtype=kind)
    heads = frame[by].iloc[firsts].reset_index(drop=True)
    return pd.concat([heads, pd.DataFrame(told)], axis=1)


def to_csv(frame: pd.DataFrame) -> str:
    """Give a table as comma-separated text, RFC 4180.

    Numbers are the shortest that read back to the same bits, missing values empty. A text that a
    spreadsheet would take for a formula gets an apostrophe in front.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow([_cell(str(name)) for name in frame.columns])
    for start in range(0, len(frame), CHUNK_ROWS):
        chunk = frame.iloc[start : start + CHUNK_ROWS]
        writer.writerows(zip(*(map(_cell, plain(chunk[name])) for name in chunk), strict=True))
    return out.getvalue()


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


def _require(name: str, frame: pd.DataFrame, option: str) -> None:
    if name not in frame.columns:
        raise InputError(
            f"there is no column {name[:200]!r}",
            field=option,
            remedy=nearest(name, map(str, frame.columns)),
        )


# Conditions


def _met(frame: pd.DataFrame, condition: str) -> NDArray[np.bool_]:
    match = CONDITION.fullmatch(condition)
    if match is None or not match[1]:
        raise InputError(
            f"{condition[:200]!r} is not column OP value, with OP one of {' '.join(OPERATORS)}",
            field="--where",
            remedy="write e.g. 'error_norm_mm<0.1' or 'detector==lin2020'",
        )
    name, sign, text = match.groups()
    _require(name, frame, "--where")
    column = frame[name]
    value = _value(text, kind_of(column), name, sign)
    return _marks(OPERATORS[sign](column, value)) & _marks(column.notna())


def _marks(column: pd.Series[Any]) -> NDArray[np.bool_]:
    """Give true and false alone; missing is false."""
    return np.asarray(column.fillna(value=False), dtype=np.bool_)


def _value(text: str, kind: str, name: str, sign: str) -> object:
    """Read the value of a condition as the column's kind."""
    if kind == "text":
        quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "'\""
        return text[1:-1] if quoted else text
    if kind == "bool":
        return _truth(text, name, sign)
    return _number(text, name, whole=kind == "int")


def _truth(text: str, name: str, sign: str) -> bool:
    if sign not in ("==", "!=") or text.lower() not in ("true", "false"):
        raise InputError(
            f"{name} is true or false, not {sign}{text[:80]!r}",
            field="--where",
            remedy=f"write {name}==true or {name}==false",
        )
    return text.lower() == "true"


def _number(text: str, name: str, *, whole: bool) -> int | float:
    if whole:
        with suppress(ValueError):
            return int(text)  # beyond 2**53 a float would be another number
    number = math.nan
    with suppress(ValueError):
        number = float(text)
    if math.isnan(number) or (whole and not number.is_integer()):
        raise InputError(
            f"{text[:80]!r} is no {'whole ' if whole else ''}number, as {name} is",
            field="--where",
            remedy="give a number",
        )
    return int(number) if whole else number


# Groups


def _groups(frame: pd.DataFrame, by: list[str]) -> tuple[list[int], list[NDArray[np.intp]]]:
    """Give the first row of each group, and all its rows, in order of the groups."""
    rows = np.arange(len(frame))
    if not by:
        return rows[:1].tolist(), [rows]
    keys = [frame[name].reset_index(drop=True) for name in by]
    # By position: several columns of one name, or missing values, would confuse names.
    numbers = frame.reset_index(drop=True).groupby(keys, sort=True, dropna=False).ngroup()
    order = np.argsort(numbers.to_numpy(), kind="stable")
    starts = np.flatnonzero(np.diff(numbers.to_numpy()[order], prepend=-1))
    groups = np.split(order, starts[1:]) if len(starts) else []
    return [int(group[0]) for group in groups], groups


def _measure(stat: str, frame: pd.DataFrame) -> tuple[Values, Callable[[Values], float]]:
    """Give the numbers that a statistic is over, one a row, and what it makes of a group's."""
    if stat == COUNT:
        return np.zeros(len(frame)), len
    if stat == RATE:
        _require("status", frame, "--stat")
        return _marks(frame["status"] == OK).astype(np.float64), _of_present(STATISTICS["mean"])
    name, _, how = stat.rpartition(":")
    known = [*STATISTICS, COUNT]
    if not name:
        also = [RATE, COUNT, *(f"{column}:mean" for column in frame.columns)]
        raise InputError(
            f"{stat[:200]!r} is no statistic", field="--stat", remedy=nearest(stat, also)
        )
    _require(name, frame, "--stat")
    if how not in known:
        raise InputError(
            f"{stat[:200]!r} asks for an unknown statistic {how[:80]!r}",
            field="--stat",
            remedy=nearest(how, known),
        )
    if how == COUNT:
        return _marks(frame[name].notna()).astype(np.float64), _total
    return _numbers(frame[name], stat), _of_present(STATISTICS[how])


def _numbers(column: pd.Series[Any], stat: str) -> Values:
    if kind_of(column) == "text":
        raise InputError(
            f"{stat[:200]!r} needs numbers, and the column is text",
            field="--stat",
            remedy="ask for its count",
        )
    return column.to_numpy(dtype=np.float64, na_value=math.nan)


def _total(present: Values) -> int:
    return int(present.sum())


def _of_present(figure: Callable[[Values], float]) -> Callable[[Values], float]:
    """Leave missing numbers out; NaN if there is none."""

    def of_present(values: Values) -> float:
        present = values[~np.isnan(values)]
        if not len(present):
            return math.nan
        with np.errstate(all="ignore"):  # an infinite value makes the figure infinite or NaN
            return figure(present)

    return of_present


# Text


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(value))
    text = str(value)
    return f"'{text}" if isinstance(value, str) and text.startswith(FORMULA) else text
