"""The detectors that can be chosen by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simtip.detect import lin2020
from simtip.detect.parameters import FIELD_PREFIX, Parameter, nearest
from simtip.detect.protocol import ConfiguredDetector, Detector
from simtip.errors import InputError

_BUILT_IN: Mapping[str, Detector] = MappingProxyType({lin2020.DETECTOR.name: lin2020.DETECTOR})


def names() -> tuple[str, ...]:
    """List the known detectors, sorted."""
    return tuple(sorted(_BUILT_IN))


def get(name: str) -> Detector:
    """Find a detector by its name.

    Raises
    ------
    InputError
        No detector has that name; the remedy is the nearest one.
    """
    try:
        return _BUILT_IN[name]
    except KeyError:
        raise InputError(
            f"there is no detector {name!r}",
            field=f"{FIELD_PREFIX}.name",
            remedy=nearest(name, names()),
        ) from None


def parameters_of(name: str) -> tuple[Parameter, ...]:
    """List what can be set on a detector: names, types, defaults, meanings.

    Raises
    ------
    InputError
        No detector has that name.
    """
    return get(name).parameters


def configure(name: str, values: Mapping[str, object] | None = None) -> ConfiguredDetector:
    """Choose a detector and its parameters.

    Parameters
    ----------
    name
        One of `names`.
    values
        Parameters by name; text is converted to the declared type. What is absent keeps its
        default.

    Raises
    ------
    InputError
        An unknown detector or parameter, or a value that does not fit.
    """
    return get(name).configure(values or {})
