"""Every detector that can be chosen, found by what its user calls it: a reference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from simtip.detect import lin2020, subpixel
from simtip.detect.command import PREFIX as COMMAND
from simtip.detect.command import command_detector
from simtip.detect.dithered import PREFIX as DITHERED
from simtip.detect.dithered import dithered_detector, undithered
from simtip.detect.imported import imported_detector
from simtip.detect.parameters import FIELD_PREFIX, Parameter, nearest
from simtip.detect.plugins import Plugin, PluginError, plugins
from simtip.detect.protocol import ConfiguredDetector, Detector
from simtip.errors import InputError

_BUILT_IN: Mapping[str, Detector] = MappingProxyType(
    {one.name: one for one in (lin2020.DETECTOR, subpixel.DETECTOR)}
)

Reference: TypeAlias = str
"""A built-in detector's name, a plug-in's, ``package.module:function`` or ``cmd:program ...``.

Before each of them may stand ``dithered:``, see `simtip.detect.dithered`.
"""


@dataclass(frozen=True)
class Listing:
    """A detector as `catalogue` lists it.

    Attributes
    ----------
    name
        By which it is chosen.
    source
        Where it comes from.
    detector
        The detector, or None if it cannot be used.
    fault
        Why it cannot be used; empty if it can.
    """

    name: str
    source: str
    detector: Detector | None
    fault: str = ""


def names() -> tuple[str, ...]:
    """List the built-in detectors and the plug-ins, sorted; no plug-in is imported for it."""
    return tuple(sorted({*_BUILT_IN, *(plugin.name for plugin in _plugins() if not plugin.fault)}))


def catalogue() -> tuple[Listing, ...]:
    """List the built-in detectors and then the plug-ins, imported, those with a fault as well."""
    built_in = [Listing(name, "built in", _BUILT_IN[name]) for name in sorted(_BUILT_IN)]
    return (*built_in, *map(_listed, _plugins()))


def get(reference: Reference) -> Detector:
    """Find a detector.

    Parameters
    ----------
    reference
        A built-in detector's name; else ``cmd:`` and a program with its arguments; else
        ``dithered:`` and another reference; else a plug-in's name; else
        ``package.module:function``. So nothing can shadow a built-in.

    Raises
    ------
    InputError
        There is no such detector (the remedy is the nearest), or it cannot be used.
    """
    if reference in _BUILT_IN:
        return _BUILT_IN[reference]
    if reference.startswith(COMMAND):
        return command_detector(reference)
    if reference.startswith(DITHERED):
        return dithered_detector(reference, get(undithered(reference)))
    for plugin in _plugins():
        if plugin.name == reference:
            return _loaded(plugin)
    if ":" in reference:
        return imported_detector(reference)
    raise InputError(
        f"there is no detector {reference!r}",
        field=f"{FIELD_PREFIX}.name",
        remedy=nearest(reference, names()),
    )


def listing(reference: Reference) -> Listing:
    """Find a detector and say where it comes from; errors are those of `get`."""
    detector = get(reference)
    if reference in _BUILT_IN:
        return Listing(reference, "built in", detector)
    if reference.startswith(COMMAND):
        return Listing(reference, "external command", detector)
    if reference.startswith(DITHERED):
        return Listing(reference, listing(undithered(reference)).source, detector)
    sources = {plugin.name: _source(plugin) for plugin in _plugins()}
    return Listing(reference, sources.get(reference, "module"), detector)


def names_code(reference: Reference) -> bool:
    """Say whether a reference names a program to start or a module to import.

    A scene file may hold such a reference, but nobody should run code by opening a file: see
    `simtip.trial.detector_of`. Built-in detectors and installed plug-ins are no such code. What is
    dithered is code if it is without that.
    """
    if reference.startswith(DITHERED):
        return names_code(reference.removeprefix(DITHERED))
    if reference in _BUILT_IN or ":" not in reference:
        return False
    return reference.startswith(COMMAND) or reference not in names()


def parameters_of(reference: Reference) -> tuple[Parameter, ...]:
    """List what can be set on a detector: names, types, defaults, meanings.

    Raises
    ------
    InputError
        There is no such detector.
    """
    return get(reference).parameters


def configure(
    reference: Reference, values: Mapping[str, object] | None = None
) -> ConfiguredDetector:
    """Choose a detector and its parameters.

    Parameters
    ----------
    reference
        As for `get`.
    values
        Parameters by name; text is converted to the declared type. What is absent keeps its
        default.

    Raises
    ------
    InputError
        An unknown detector or parameter, or a value that does not fit.
    """
    return get(reference).configure(values or {})


def _plugins() -> tuple[Plugin, ...]:
    return plugins(frozenset(_BUILT_IN))


def _source(plugin: Plugin) -> str:
    return f"plug-in of {plugin.distribution} ({plugin.value})"


def _listed(plugin: Plugin) -> Listing:
    try:
        return Listing(plugin.name, _source(plugin), plugin.load())
    except PluginError as error:
        return Listing(plugin.name, _source(plugin), None, str(error))


def _loaded(plugin: Plugin) -> Detector:
    try:
        return plugin.load()
    except PluginError as error:
        raise InputError(
            f"the plug-in {plugin.name!r} cannot be used: {error}",
            field=f"{FIELD_PREFIX}.name",
            remedy=f"mend or remove {plugin.distribution}",
        ) from error
