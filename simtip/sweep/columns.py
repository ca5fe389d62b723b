"""The columns of a sweep's table, and what their cells may hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

Kind = Literal["int", "float", "text", "bool"]
Row = dict[str, object]


@dataclass(frozen=True)
class Column:
    """One column of the table; any of its values may be missing.

    Parameters
    ----------
    name
        Plain, or the path of a field such as ``lamps[0].power``.
    kind
        ``int`` (64 bits, signed), ``float`` (64 bits, NaN is missing), ``text`` or ``bool``.
    """

    name: str
    kind: Kind


def _of(kind: Kind, names: str) -> tuple[Column, ...]:
    return tuple(Column(name, kind) for name in names.split())


_BEFORE = (*_of("text", "key"), *_of("int", "trial repeat noise_seed"), *_of("text", "detector"))
_AFTER = (
    *_of("text", "status reason"),
    *_of("float", "error_x_mm error_y_mm error_z_mm error_norm_mm refined_norm_mm"),
    *_of("float", "left_error_u_px left_error_v_px left_error_along_px left_error_across_px"),
    *_of("float", "right_error_u_px right_error_v_px right_error_along_px right_error_across_px"),
    *_of("float", "tip_x_mm tip_y_mm tip_z_mm exposure_s"),
    *_of("text", "light_key image_key code"),
    *_of("float", "render_s sensor_s detect_s"),
)
FIXED = (*_BEFORE, *_AFTER)
"""The columns of every sweep; those of its factors stand after ``detector``."""


def columns_for(factors: Iterable[Column]) -> tuple[Column, ...]:
    """Give all columns of a sweep with these factors, in order.

    Raises
    ------
    ValueError
        Two have the same name.
    """
    return checked((*_BEFORE, *factors, *_AFTER))


def checked(columns: Iterable[Column]) -> tuple[Column, ...]:
    """Give columns that a table may have; raise ValueError for others."""
    given = tuple(columns)
    names = [column.name for column in given]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"two columns are named {min(twice)!r}")
    if any(column.kind not in get_args(Kind) for column in given):
        raise ValueError(f"a column's kind is none of {', '.join(get_args(Kind))}")
    needed = {Column("key", "text"), Column("trial", "int"), Column("status", "text")}
    missing = needed - set(given)
    if missing:
        raise ValueError(f"no column {min(column.name for column in missing)!r} as it has to be")
    return given


def fitting(column: Column, values: list[object]) -> list[object]:
    """Give a column's values as plain Python ones."""
    plain = _PLAIN[column.kind]
    for k, value in enumerate(values):
        if value is not None:
            try:
                values[k] = plain(value)
            except (TypeError, OverflowError):
                text = repr(value)[:80]
                raise TypeError(f"column {column.name!r}: {text} is no {column.kind}") from None
        elif column.name == "key":
            raise TypeError("column 'key': a row has no key")
    return values


def _plain_int(value: object) -> int:
    if not isinstance(value, int | np.integer) or isinstance(value, bool):
        raise TypeError
    if not -(2**63) <= value < 2**63:
        raise OverflowError
    return int(value)


def _plain_float(value: object) -> float | None:
    if not isinstance(value, float | int | np.floating | np.integer) or isinstance(value, bool):
        raise TypeError
    number = float(value)
    return None if math.isnan(number) else number


def _plain_text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError
    # Names of files may hold what is no Unicode.
    return value.encode("utf-8", "backslashreplace").decode()


def _plain_bool(value: object) -> bool:
    if not isinstance(value, bool | np.bool_):
        raise TypeError
    return bool(value)


_PLAIN: dict[Kind, Callable[[object], object]] = {
    "int": _plain_int,
    "float": _plain_float,
    "text": _plain_text,
    "bool": _plain_bool,
}
