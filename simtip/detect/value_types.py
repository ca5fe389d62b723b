"""The types that a detector's parameters may have, and how text becomes values of them."""

from __future__ import annotations

import math
import reprlib
import types
from typing import Literal, Union, cast, get_args, get_origin


def _is_optional(hint: object) -> bool:
    return get_origin(hint) in (Union, types.UnionType) and type(None) in get_args(hint)


def _without_none(hint: object) -> object:
    return next(h for h in get_args(hint) if h is not type(None))


def in_words(hint: object) -> str:
    """Say what a type takes: ``int``, ``dark | bright``, ``3 x float``, ``int | none``."""
    if _is_optional(hint):
        return f"{in_words(_without_none(hint))} | none"
    if get_origin(hint) is Literal:
        return " | ".join(map(str, get_args(hint)))
    if get_origin(hint) is tuple:
        return f"{len(get_args(hint))} x float"
    return "text" if hint is str else cast("type", hint).__name__


def is_supported(hint: object) -> bool:
    """Say whether `converted` knows the type."""
    if _is_optional(hint):
        return len(get_args(hint)) == 2 and is_supported(_without_none(hint))
    if get_origin(hint) is Literal:
        return True
    if get_origin(hint) is tuple:
        return bool(get_args(hint)) and all(item is float for item in get_args(hint))
    return hint in (int, float, bool, str)


def converted(hint: object, value: object) -> object:
    """Convert a value to a declared type; the text ``"105"`` serves where an int is declared.

    Raises
    ------
    TypeError, ValueError, OverflowError
        It does not fit; the message says so.
    """
    if _is_optional(hint):
        none = value is None or (isinstance(value, str) and value.lower() in ("none", "null"))
        return None if none else converted(_without_none(hint), value)
    if get_origin(hint) is Literal:
        return _choice(get_args(hint), value)
    if get_origin(hint) is tuple:
        return _floats(len(get_args(hint)), value)
    simple = {bool: _bool, int: _int, str: _text}.get(cast("type", hint), _float)
    return simple(value)


def _shown(value: object) -> str:
    """Quote a value that the user gave, cut short if it is long."""
    return reprlib.repr(value)


def _choice(choices: tuple[object, ...], value: object) -> object:
    for choice in choices:
        # by text, so that "8" is 8; a bool is no number here
        if str(choice) == str(value):
            return choice
    raise ValueError(f"{_shown(value)} is not one of {', '.join(map(str, choices))}")


def _bool(value: object) -> bool:
    if isinstance(value, bool):
        return value
    if isinstance(value, str) and value.lower() in ("true", "false"):
        return value.lower() == "true"
    raise ValueError(f"{_shown(value)} is neither true nor false")


def _int(value: object) -> int:
    try:
        number = int(value) if isinstance(value, str) else _float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{_shown(value)} is not a whole number") from None
    if number != int(number):
        raise ValueError(f"{_shown(value)} is not a whole number")
    return int(number)


def _float(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise TypeError(f"{_shown(value)} is not a number")
    try:
        number = float(value)
    except ValueError:
        raise ValueError(f"{_shown(value)} is not a number") from None
    if not math.isfinite(number):
        raise ValueError(f"{_shown(value)} is not finite")
    return number


def _text(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise TypeError(f"{_shown(value)} is no text")
    return str(value)


def _floats(count: int, value: object) -> tuple[float, ...]:
    items = value.split(",") if isinstance(value, str) else value
    if not isinstance(items, (list, tuple)) or len(items) != count:
        raise ValueError(f"{_shown(value)} is not {count} numbers")
    return tuple(_float(item) for item in items)


def check_range(value: object, minimum: float | None, maximum: float | None) -> None:
    """Raise ValueError for a number, or a number of a tuple, outside of an inclusive range."""
    for number in value if isinstance(value, tuple) else (value,):
        if not isinstance(number, (int, float)) or isinstance(number, bool):
            continue
        if minimum is not None and number < minimum:
            raise ValueError(f"{number:g} is below {minimum:g}")
        if maximum is not None and number > maximum:
            raise ValueError(f"{number:g} is above {maximum:g}")
