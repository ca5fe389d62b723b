"""Conditions that rows of a table of results have to meet: ``column OP value``."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.sweep.compact import compact
from simtip.sweep.frames import kind_of, marks, require

if TYPE_CHECKING:
    import pandas as pd

CONDITION = re.compile(r"\s*(.*?)\s*(==|!=|<=|>=|<|>)\s*(.*?)\s*", re.DOTALL)
OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def filtered(frame: pd.DataFrame, conditions: Iterable[str]) -> pd.DataFrame:
    """Keep the rows that meet all conditions.

    Parameters
    ----------
    frame
        As `Table.frame` gives it.
    conditions
        Each ``column OP value``, OP being one of ``== != < <= > >=``; the value is read as the
        column's kind, a part of a scene as JSON or in few words (`simtip.sweep.compact`). A missing
        value meets no condition.

    Raises
    ------
    InputError
        A condition cannot be read, or there is no such column.
    """
    keep = np.ones(len(frame), dtype=np.bool_)
    for condition in conditions:
        keep &= _met(frame, condition)
    return frame.loc[keep].reset_index(drop=True)


def _met(frame: pd.DataFrame, condition: str) -> NDArray[np.bool_]:
    match = CONDITION.fullmatch(condition)
    if match is None or not match[1]:
        raise InputError(
            f"{condition[:200]!r} is not column OP value, with OP one of {' '.join(OPERATORS)}",
            field="--where",
            remedy="write e.g. 'error_norm_mm<0.1' or 'detector==lin2020'",
        )
    name, sign, text = match.groups()
    require(name, frame, "--where")
    column = frame[name]
    value = _value(text, kind_of(column), name, sign)
    if kind_of(column) == "text" and not marks(column == value).any():
        # Parts may be named as they are shown, too.
        column = column.map(compact, na_action="ignore")
    return marks(OPERATORS[sign](column, value)) & marks(column.notna())


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
