"""Which detector is tried: each scene's own, or one that is named; with other parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from simtip.detect import names_code
from simtip.errors import InputError
from simtip.regress.baseline import DetectorReference
from simtip.spec import SceneSpec
from simtip.sweep.spec import DetectorEntry


@dataclass(frozen=True)
class Chosen:
    """A detector.

    Attributes
    ----------
    name
        See `simtip.detect.get`; None is each scene's own.
    parameters
        In place of its own.
    allowed
        Whether the caller is willing to run it, if it is a program or a module.
    """

    name: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    allowed: bool = False

    def entry(self, scene: SceneSpec) -> list[str | DetectorEntry]:
        """Give it as the detectors of a sweep of a scene."""
        name = scene.detect.name if self.name is None else self.name
        return [DetectorEntry.model_validate({**self.parameters, "name": name})]

    @property
    def allowed_names(self) -> tuple[str, ...]:
        """Give the programs and modules that may run."""
        return (self.name,) if self.allowed and self.name is not None else ()

    @property
    def reference(self) -> DetectorReference:
        """Give it as a baseline keeps it."""
        return DetectorReference(name=self.name, parameters=dict(self.parameters))

    def __str__(self) -> str:
        """Give it in words."""
        name = "the scenes' own" if self.name is None else self.name
        values = ", ".join(f"{key}={value}" for key, value in self.parameters.items())
        return f"{name} ({values})" if values else name


def chosen_for(
    recorded: DetectorReference, name: str | None, parameters: Mapping[str, Any]
) -> Chosen:
    """Choose a baseline's detector, or a candidate in its place.

    Parameters
    ----------
    recorded
        The baseline's.
    name, parameters
        As given by the caller. Recorded parameters stay if the detector is the same.

    Raises
    ------
    InputError
        The baseline's own is code, and the caller did not name it.
    """
    if name is None and recorded.name is not None and names_code(recorded.name):
        raise InputError(
            f"the baseline is of a program or module ({recorded.name[:80]}), "
            "which a file may not start by itself",
            field="--detector",
            remedy="if you trust it, name it by --detector",
        )
    same = name is None or name == recorded.name
    kept = recorded.parameters if same else {}
    return Chosen(recorded.name if name is None else name, {**kept, **parameters}, name is not None)
