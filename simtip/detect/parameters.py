"""How a detector declares its parameters, and how values from a file or a command line fit them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, Final, Self, cast, get_type_hints

from simtip.camera import Camera
from simtip.detect.value_types import check_range, converted, in_words
from simtip.errors import InputError

FIELD_PREFIX = "detect"
"""The part of a scene that holds these values: errors name ``detect.threshold``."""

REQUIRED: Final = MISSING
"""Stands for the default of a parameter that has none."""


@dataclass(frozen=True)
class Parameter:
    """One declared parameter of a detector.

    Attributes
    ----------
    name
        As written in a scene or after ``--set``.
    type
        In words: ``int``, ``float``, ``text``, ``dark | bright``, ``3 x float``, ``int | none``.
    default
        Value when none is given; None, too, if there is no default.
    description
        What it does, with its unit.
    required
        Whether a value has to be given.
    """

    name: str
    type: str
    default: object
    description: str
    required: bool = False


@dataclass(frozen=True)
class Declared:
    """What a parameter means, put into its ``Annotated`` type.

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
class Declaration:
    """A parameter with all that is needed to check a value for it.

    Attributes
    ----------
    name
        As written in a scene or after ``--set``.
    hint
        Its type, one that `simtip.detect.value_types` knows.
    default
        Value when none is given, or `REQUIRED`.
    declared
        Description and range.
    """

    name: str
    hint: object
    default: object
    declared: Declared

    @property
    def parameter(self) -> Parameter:
        """The same for lists and help."""
        required = self.default is REQUIRED
        default = None if required else self.default
        description = self.declared.description
        return Parameter(self.name, in_words(self.hint), default, description, required)

    def value(self, given: object) -> object:
        """Convert a value to the declared type; raise `InputError` if it does not fit."""
        limits = self.declared.minimum, self.declared.maximum
        try:
            value = converted(self.hint, given)
            check_range(value, *limits)
        except (TypeError, ValueError, OverflowError) as error:
            raise bad_value(self.name, str(error), self._remedy()) from error
        return value

    def _remedy(self) -> str:
        limits = {"at least": self.declared.minimum, "at most": self.declared.maximum}
        given = [f"{word} {limit:g}" for word, limit in limits.items() if limit is not None]
        about = f": {self.declared.description}" if self.declared.description else ""
        return f"give {' '.join([in_words(self.hint), *given])}{about}"


def values_of(declarations: Iterable[Declaration], given: Mapping[str, object]) -> dict[str, Any]:
    """Check and convert the values that a scene or ``--set`` gives; defaults fill up the rest.

    Raises
    ------
    InputError
        A name is unknown (the remedy is the nearest known one), a value does not fit, or one that
        is required is missing.
    """
    by_name = {declaration.name: declaration for declaration in declarations}
    check_names(given, by_name)
    values: dict[str, Any] = {}
    for name, declaration in by_name.items():
        value = given.get(name, declaration.default)
        if value is REQUIRED:
            remedy = f"give it by --set {name}=... or beside the detector's name in the scene"
            raise bad_value(name, "has no value", remedy)
        values[name] = declaration.value(value)
    return values


def check_names(given: Iterable[str], known: Iterable[str]) -> None:
    """Raise `InputError` for a name that no parameter has."""
    names = list(known)
    for name in given:
        if name not in names:
            raise InputError(
                f"the detector has no parameter {name!r}",
                field=f"{FIELD_PREFIX}.{name}",
                remedy=nearest(str(name), names) if names else "it has none",
            )


@dataclass(frozen=True)
class DetectorParameters:
    """Base of the parameter classes: frozen dataclasses.

    Each field is ``Annotated[type, Declared(...)]`` with a default.
    Types may be ``int``, ``float``, ``bool``, ``str``, ``Literal``, a tuple of floats of fixed
    length, or one of these with ``| None``. Values are converted to the declared type, so the
    text ``"105"`` and the number ``105.0`` both serve where an int is declared.

    Raises
    ------
    InputError
        A value does not fit; the error names its field, e.g. ``detect.threshold``.
    """

    def __post_init__(self) -> None:
        for declaration in self._declarations():
            value = declaration.value(getattr(self, declaration.name))
            object.__setattr__(self, declaration.name, value)

    def for_camera(self, _camera: Camera, /) -> Self:
        """Fill in what is not set and follows from the camera; as it is, nothing does."""
        return self

    def for_region(self, _u0: int, _v0: int, _shape: tuple[int, ...], /) -> Self:
        """Give them for a region of an image of that shape; as they are, if none is a place."""
        return self

    @classmethod
    def declared(cls) -> tuple[Parameter, ...]:
        """List the parameters in the order of their declaration."""
        return tuple(declaration.parameter for declaration in cls._declarations())

    @classmethod
    def from_mapping(cls, values: Mapping[str, object]) -> Self:
        """Build from names and values, as a scene or ``--set`` gives them.

        Raises
        ------
        InputError
            A name is unknown (the remedy is the nearest known one), or a value does not fit.
        """
        check_names(values, (item.name for item in fields(cls)))
        return cls(**cast("dict[str, Any]", dict(values)))

    @classmethod
    def _declarations(cls) -> tuple[Declaration, ...]:
        hints = get_type_hints(cls, include_extras=True)
        return tuple(
            Declaration(
                item.name,
                hints[item.name].__origin__,
                item.default,
                hints[item.name].__metadata__[0],
            )
            for item in fields(cls)
        )


def bad_value(name: str, problem: str, remedy: str) -> InputError:
    """Make the error for a value that does not fit the parameter of that name."""
    return InputError(problem, field=f"{FIELD_PREFIX}.{name}", remedy=remedy)


def nearest(name: str, known: Iterable[str]) -> str:
    """Say which known name was probably meant, or list them all."""
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(names)}"
