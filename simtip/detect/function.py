"""A plain function as a detector: its signature declares the parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, get_args, get_origin, get_type_hints

from simtip.detect.guarded import GuardedDetector
from simtip.detect.parameters import (
    FIELD_PREFIX,
    REQUIRED,
    Declaration,
    Declared,
    values_of,
)
from simtip.detect.protocol import Image
from simtip.detect.value_types import is_supported
from simtip.errors import InputError

LAYERS = "layers"
"""A parameter of this name is no setting: it is True when pictures of the steps are wanted."""
RESERVED = "name"
"""In a scene this key names the detector itself."""

Function = Callable[..., object]


def function_detector(name: str, function: Function) -> GuardedDetector:
    """Make a detector of ``function(image, **parameters)``.

    Parameters
    ----------
    name
        By which it is chosen.
    function
        Its first argument is the image. All others are its parameters: their annotations (int,
        float, bool, str, Literal, a tuple of floats of fixed length, each perhaps ``| None``, and
        ``Annotated[type, "what it does"]`` or ``Annotated[type, Declared(...)]`` of one) and their
        defaults declare them. Without an annotation the default's type counts. What it may give is
        said at `simtip.detect.outcome.observed`.

    Raises
    ------
    InputError
        It takes no image, or has a parameter that cannot be set by a text.
    """
    parameters = _after_image(name, function)
    wants_layers = LAYERS in parameters
    declarations = [
        _declaration(name, function, parameter)
        for parameter in parameters.values()
        if parameter.name != LAYERS
    ]

    def prepare(values: Mapping[str, object]) -> Function:
        settings = values_of(declarations, values)

        def run(image: Image, *, layers: bool = False) -> object:
            more = {LAYERS: layers} if wants_layers else {}
            return function(image, **settings, **more)

        return run

    declared = tuple(declaration.parameter for declaration in declarations)
    return GuardedDetector(name, _summary(function), declared, prepare)


def _after_image(name: str, function: Function) -> Mapping[str, inspect.Parameter]:
    """Give the parameters after the image, without ``*args`` and ``**kwargs``."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError) as error:
        raise _unusable(name, f"tells no signature ({error})") from error
    takes = {inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD}
    if not parameters or parameters[0].kind not in {*takes, inspect.Parameter.VAR_POSITIONAL}:
        raise _unusable(name, "takes no image as its first argument")
    named = {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
    return {item.name: item for item in parameters[1:] if item.kind in named}


def _declaration(name: str, function: Function, parameter: inspect.Parameter) -> Declaration:
    if parameter.name == RESERVED:
        raise _unusable(name, f"has a parameter {RESERVED!r}, which names the detector in scenes")
    missing = parameter.default is inspect.Parameter.empty
    hint, declared = _hint(name, function, parameter)
    if not is_supported(hint):
        raise _unusable(
            name,
            f"has a parameter {parameter.name!r} of no type that a text can give",
            "annotate it with int, float, bool, str, Literal[...] or tuple[float, float]",
        )
    default = REQUIRED if missing else parameter.default
    return Declaration(parameter.name, hint, default, declared)


def _hint(name: str, function: Function, parameter: inspect.Parameter) -> tuple[object, Declared]:
    """Give the type, and what ``Annotated`` adds to it."""
    if parameter.annotation is inspect.Parameter.empty:
        return type(parameter.default), Declared("")
    # One at a time: that of the image may name what is imported for type checkers only.
    annotations = {parameter.name: parameter.annotation}
    holder = type("_Holder", (), {"__annotations__": annotations})
    inner = inspect.unwrap(getattr(function, "func", function))  # of a functools.partial
    scope = getattr(inner, "__globals__", None) or getattr(inner.__call__, "__globals__", {})
    try:
        hint = get_type_hints(holder, scope, include_extras=True)[parameter.name]
    except (NameError, SyntaxError, TypeError, AttributeError) as error:
        problem = f"has a parameter {parameter.name!r} whose annotation cannot be read ({error})"
        raise _unusable(name, problem) from error
    if get_origin(hint) is not Annotated:
        return hint, Declared("")
    base, *extras = get_args(hint)
    for extra in extras:
        if isinstance(extra, Declared):
            return base, extra
        if isinstance(extra, str):
            return base, Declared(extra)
    return base, Declared("")


def _summary(function: Function) -> str:
    return (inspect.getdoc(function) or "").strip().partition("\n")[0]


def _unusable(name: str, problem: str, remedy: str = "mend the detector") -> InputError:
    return InputError(f"{name} {problem}", field=f"{FIELD_PREFIX}.name", remedy=remedy)
