"""Detectors of installed packages: the entry points of the group ``simtip.detectors``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata

from simtip.detect.adopted import adopted
from simtip.detect.excerpt import excerpt
from simtip.detect.foreign_code import ForeignCodeError, foreign_code
from simtip.detect.guarded import GuardedDetector
from simtip.errors import InputError

GROUP = "simtip.detectors"


class PluginError(Exception):
    """A plug-in cannot be used; the text says why."""


@dataclass(frozen=True)
class Plugin:
    """An entry point that names a detector; nothing of it is imported yet.

    Attributes
    ----------
    name
        By which it is chosen.
    distribution
        The installed package with its version.
    value
        ``module:object``.
    fault
        Why it cannot be used, as far as known without importing it; empty if nothing is known.
    """

    name: str
    distribution: str
    value: str
    fault: str = ""

    def load(self) -> GuardedDetector:
        """Import it.

        Raises
        ------
        PluginError
            It has a fault, its module cannot be imported, or the object is no detector.
        """
        if self.fault:
            raise PluginError(self.fault)
        try:
            with foreign_code():
                found = metadata.EntryPoint(self.name, self.value, GROUP).load()
                return adopted(self.name, found)
        except (ForeignCodeError, InputError) as error:
            problem = error.problem if isinstance(error, InputError) else str(error)
            raise PluginError(problem) from error


def plugins(taken: frozenset[str] = frozenset()) -> tuple[Plugin, ...]:
    """List the plug-ins that are installed, sorted by name, without importing any.

    Parameters
    ----------
    taken
        Names that no plug-in may have: one that claims such a name is listed with that fault.
    """
    found = sorted(_entry_points(), key=lambda plugin: (plugin.name, plugin.distribution))
    owners: dict[str, list[str]] = {}
    for plugin in found:
        owners.setdefault(plugin.name, []).append(plugin.distribution)
    return tuple(_with_fault(plugin, owners[plugin.name], taken) for plugin in found)


def _with_fault(plugin: Plugin, owners: list[str], taken: frozenset[str]) -> Plugin:
    fault = plugin.fault
    if plugin.name in taken:
        fault = f"{plugin.name} is built in, and no plug-in can take its place"
    elif len(owners) > 1:
        fault = f"its name is claimed {len(owners)} times, by {', '.join(owners)}"
    return Plugin(plugin.name, plugin.distribution, plugin.value, fault)


def _entry_points() -> Iterator[Plugin]:
    seen: set[str] = set()
    for distribution in metadata.distributions():
        try:
            # Metadata of others: one broken package must hide no other.
            with foreign_code():
                points = [point for point in distribution.entry_points if point.group == GROUP]
                if not points:
                    continue
                name = str(distribution.metadata["Name"])
                label = excerpt(f"{name} {distribution.version}", 80)
        except ForeignCodeError:
            continue
        # Of a package that is found twice, Python imports the first.
        if name.lower() in seen:
            continue
        seen.add(name.lower())
        for point in points:
            yield Plugin(point.name, label, point.value)
