"""How a detector declares its parameters, and how values from a file or a command line fit them."""

from __future__ import annotations

import difflib
import math
import reprlib
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, Self, Union, cast, get_args, get_origin, get_type_hints

from simtip.errors import InputError

FIELD_PREFIX = "detect"
"""The part of a scene that holds these values: errors name ``detect.threshold``."""


@dataclass(frozen=True)
class Parameter:
    """One declared parameter of a detector.

    Attributes
    ----------
    name
        As written in a scene or after ``--set``.
    type
        In words: ``int``, ``float``, ``dark | bright``, ``3 x float``, ``int | none``.
    default
        Value when none is given.
    description
        What it does, with its unit.
    """

    name: str
    type: str
    default: object
    description: str


@dataclass(frozen=True)
class Declared:
    """What a `DetectorParameters` field means, put into its ``Annotated`` type.

    Attributes
    ----------
    description
        What the parameter does, with its unit.
    minimum, maximum
        Inclusive range, if there is one.
    """

    description: str
    minimum: float | None = None
    maximum: float | None = None


@dataclass(frozen=True)
class DetectorParameters:
    """Base of the parameter classes: frozen dataclasses.

    Each field is ``Annotated[type, Declared(...)]`` with a default.
    Types may be ``int``, ``float``, ``bool``, ``Literal``, a tuple of floats of fixed
    length, or one of these with ``| None``. Values are converted to the declared type, so the
    text ``"105"`` and the number ``105.0`` both serve where an int is declared.

    Raises
    ------
    InputError
        A value does not fit; the error names its field, e.g. ``detect.threshold``.
    """

    def __post_init__(self) -> None:
        for name, (hint, declared) in _annotations(type(self)).items():
            try:
                converted = _converted(hint, getattr(self, name))
                _check_range(converted, declared.minimum, declared.maximum)
            except (TypeError, ValueError, OverflowError) as error:
                raise bad_value(name, str(error), _remedy(hint, declared)) from error
            object.__setattr__(self, name, converted)

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """List the parameters in the order of their declaration."""
        defaults = {item.name: item.default for item in fields(cls)}
        return tuple(
            Parameter(name, _in_words(hint), defaults[name], declared.description)
            for name, (hint, declared) in _annotations(cls).items()
        )

    @classmethod
    def from_mapping(cls, values: Mapping[str, object]) -> Self:
        """Build from names and values, as a scene or ``--set`` gives them.

        Raises
        ------
        InputError
            A name is unknown (the remedy is the nearest known one), or a value does not fit.
        """
        known = [item.name for item in fields(cls)]
        for name in values:
            if name not in known:
                raise InputError(
                    f"the detector has no parameter {name!r}",
                    field=f"{FIELD_PREFIX}.{name}",
                    remedy=nearest(str(name), known),
                )
        return cls(**cast("dict[str, Any]", dict(values)))


def _annotations(cls: type[DetectorParameters]) -> dict[str, tuple[object, Declared]]:
    """Give the type and the declaration of each field."""
    hints = get_type_hints(cls, include_extras=True)
    return {
        item.name: (hints[item.name].__origin__, hints[item.name].__metadata__[0])
        for item in fields(cls)
    }


def bad_value(name: str, problem: str, remedy: str) -> InputError:
    """Make the error for a value that does not fit the parameter of that name."""
    return InputError(problem, field=f"{FIELD_PREFIX}.{name}", remedy=remedy)


def nearest(name: str, known: Iterable[str]) -> str:
    """Say which known name was probably meant, or list them all."""
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(names)}"


def _remedy(hint: object, declared: Declared) -> str:
    limits = {"at least": declared.minimum, "at most": declared.maximum}
    given = [f"{word} {limit:g}" for word, limit in limits.items() if limit is not None]
    return f"give {' '.join([_in_words(hint), *given])}: {declared.description}"


def _is_optional(hint: object) -> bool:
    return get_origin(hint) in (Union, types.UnionType) and type(None) in get_args(hint)


def _without_none(hint: object) -> object:
    return next(h for h in get_args(hint) if h is not type(None))


def _in_words(hint: object) -> str:
    if _is_optional(hint):
        return f"{_in_words(_without_none(hint))} | none"
    if get_origin(hint) is Literal:
        return " | ".join(map(str, get_args(hint)))
    if get_origin(hint) is tuple:
        return f"{len(get_args(hint))} x float"
    return cast("type", hint).__name__


def _converted(hint: object, value: object) -> object:
    if _is_optional(hint):
        none = value is None or (isinstance(value, str) and value.lower() in ("none", "null"))
        return None if none else _converted(_without_none(hint), value)
    if get_origin(hint) is Literal:
        return _choice(get_args(hint), value)
    if get_origin(hint) is tuple:
        return _floats(len(get_args(hint)), value)
    if hint is bool:
        return _bool(value)
    if hint is int:
        return _int(value)
    return _float(value)


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


def _floats(count: int, value: object) -> tuple[float, ...]:
    items = value.split(",") if isinstance(value, str) else value
    if not isinstance(items, (list, tuple)) or len(items) != count:
        raise ValueError(f"{_shown(value)} is not {count} numbers")
    return tuple(_float(item) for item in items)


def _check_range(value: object, minimum: float | None, maximum: float | None) -> None:
    for number in value if isinstance(value, tuple) else (value,):
        if not isinstance(number, (int, float)) or isinstance(number, bool):
            continue
        if minimum is not None and number < minimum:
            raise ValueError(f"{number:g} is below {minimum:g}")
        if maximum is not None and number > maximum:
            raise ValueError(f"{number:g} is above {maximum:g}")
