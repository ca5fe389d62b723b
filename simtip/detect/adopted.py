"""An object from somebody's module or plug-in as a detector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

from simtip.detect.function import function_detector
from simtip.detect.guarded import GuardedDetector
from simtip.detect.parameters import FIELD_PREFIX, Parameter
from simtip.detect.protocol import ConfiguredDetector, Detector
from simtip.errors import InputError


def adopted(name: str, found: object) -> GuardedDetector:
    """Make a detector of an object that follows the `Detector` protocol, or of a function.

    Parameters
    ----------
    name
        By which it is chosen, whatever it calls itself.
    found
        The object.

    Raises
    ------
    InputError
        It is neither, or a class.
    """
    if isinstance(found, type) or not callable(found):
        what = "a class" if isinstance(found, type) else f"of the type {type(found).__name__}"
        raise InputError(
            f"{name} is {what}, not a detector",
            field=f"{FIELD_PREFIX}.name",
            remedy="name a function, or an object with configure() and parameters",
        )
    if not (hasattr(found, "configure") and hasattr(found, "parameters")):
        return function_detector(name, found)
    detector = cast("Detector", found)

    def prepare(values: Mapping[str, object]) -> ConfiguredDetector:
        return detector.configure(values)

    parameters = tuple(
        Parameter(
            str(item.name),
            str(item.type),
            item.default,
            str(item.description),
            bool(getattr(item, "required", False)),
        )
        for item in detector.parameters
    )
    return GuardedDetector(name, str(getattr(found, "summary", "")), parameters, prepare)
