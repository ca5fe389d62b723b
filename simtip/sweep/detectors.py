"""The detectors of a sweep, each with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from simtip.detect import ConfiguredDetector, names_code, parameters_of
from simtip.detect.registry import listing
from simtip.errors import InputError
from simtip.spec import SceneSpec
from simtip.spec.scene import DetectSpec
from simtip.sweep.spec import DetectorEntry, SweepSpec
from simtip.trial import detector_of


@dataclass(frozen=True)
class Measuring:
    """A detector and how it is set.

    Attributes
    ----------
    label
        In the table.
    reference
        Which detector, see `simtip.detect.get`.
    parameters
        By name, as given.
    allowed
        Whether the caller is willing to run it, if it is a program or module.
    """

    label: str
    reference: str
    parameters: Mapping[str, Any]
    allowed: bool = False

    @property
    def is_own(self) -> bool:
        """Whether it is simtip's own: then all it depends on is known."""
        if self.reference.startswith("cmd:") or names_code(self.reference):
            return False
        return bool(listing(self.reference).source == "built in")

    @cached_property
    def declared(self) -> dict[str, str]:
        """Type of every parameter, in words, by name."""
        return {one.name: one.type for one in parameters_of(self.reference)}

    def type_of(self, name: str) -> str | None:
        """Give a parameter's type in words; None if there is none of that name."""
        return self.declared.get(name)

    def with_parameters(self, values: Mapping[str, Any]) -> Measuring:
        """Give it with other parameters; those it does not have are left out."""
        taken = {name: value for name, value in values.items() if name in self.declared}
        return replace(self, parameters={**self.parameters, **taken}) if taken else self

    @property
    def identity(self) -> list[Any]:
        """Tell it from any other, as plain data."""
        return [self.label, self.reference, dict(sorted(self.parameters.items()))]

    @property
    def spec(self) -> DetectSpec:
        """Give it as a part of a scene."""
        return DetectSpec.model_validate({**self.parameters, "name": self.reference})

    def configured(self, scene: SceneSpec) -> ConfiguredDetector:
        """Set it up for a scene's images, of which a detector is told what white is.

        Raises
        ------
        InputError
            A parameter does not fit, or it is code that the caller did not allow.
        """
        spec = scene.model_copy(update={"detect": self.spec})
        return detector_of(spec, allowed=self.reference if self.allowed else None)


def measuring(spec: SweepSpec, scene: SceneSpec, allowed: tuple[str, ...]) -> tuple[Measuring, ...]:
    """Set up a sweep's detectors.

    Parameters
    ----------
    spec
        The sweep.
    scene
        Its scene, of which the detector is taken if the sweep names none.
    allowed
        Detectors that are programs or modules, which the caller is willing to run.

    Raises
    ------
    InputError
        A detector or parameter does not exist, a value does not fit, or two have one label.
    """
    entries = spec.detectors or [scene.detect.name]
    made: list[Measuring] = []
    for number, entry in enumerate(entries):
        given = DetectorEntry(name=entry) if isinstance(entry, str) else entry
        own = scene.detect.parameters() if given.name == scene.detect.name else {}
        values = {**own, **given.parameters()}
        label = given.label or given.name
        one = Measuring(label, given.name, values, given.name in allowed)
        try:
            one.configured(scene)
        except InputError as error:
            field = error.field if spec.detectors is None else f"detectors[{number}]"
            raise InputError(error.problem, field=field, remedy=error.remedy) from error
        if label in {other.label for other in made}:
            raise InputError(
                f"is the second {label!r}",
                field=f"detectors[{number}]",
                remedy="give it a label of its own",
            )
        made.append(one)
    return tuple(made)
