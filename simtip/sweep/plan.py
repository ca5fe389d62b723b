"""All trials of a sweep by number: which values, which repeat, which detector.

Trials are numbered so that those which share a render stand together, and within them those that
share their images. Nothing is listed: a trial is worked out from its number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from simtip.light_inputs import light_digest
from simtip.measuring_rig import measuring_rig
from simtip.mix import steady_weights
from simtip.noise_budget import noise_tolerance
from simtip.spec import SceneSpec
from simtip.sweep.assignment import Scenes, require_plain
from simtip.sweep.columns import Kind
from simtip.sweep.detectors import Measuring, measuring
from simtip.sweep.levels import Dimension, mixed_radix, points
from simtip.sweep.spec import MEASURED, GridSpec, SampledSpec, SweepSpec
from simtip.sweep.stage_keys import code_digest, digest_of, rig_digest
from simtip.sweep.varying import DETECT, tried_levels, varying


@dataclass(frozen=True)
class Trial:
    """One trial.

    Attributes
    ----------
    number
        In the plan.
    values
        Of the scene's fields, without the detector's parameters.
    repeat
        0, 1, ...
    measuring
        Which detector, with its parameters.
    factors
        What the table says of it, by column.
    """

    number: int
    values: Mapping[str, Any]
    repeat: int
    measuring: Measuring
    factors: Mapping[str, Any]


class Plan:
    """The trials of a sweep.

    Parameters
    ----------
    spec
        The sweep.
    scene
        Its scene, as it is in its file.
    allowed
        Detectors that are programs or modules, which the caller is willing to run.
    name
        Of the sweep's file, for messages.

    Raises
    ------
    InputError
        A field or a parameter does not exist, or a value does not fit.
    """

    def __init__(
        self, spec: SweepSpec, scene: SceneSpec, allowed: tuple[str, ...] = (), name: str = ""
    ) -> None:
        self.spec, self.allowed = spec, allowed
        require_plain(spec.base)
        self.scenes = Scenes(Scenes(scene, name).with_values(spec.base), name)
        self.base = self.scenes.base
        self._lit = self.scenes
        if spec.render_for:
            self._lit = Scenes(self.scenes.with_values(spec.render_for), name)
        self.seed = self.base.seed if spec.seed is None else spec.seed
        self.detectors = measuring(spec, self.base, allowed)
        found = varying(spec, self.scenes, self.detectors)
        self.rendered, self.mixed, self.measured = found.light, found.images, found.measurement

    def __len__(self) -> int:
        """Give the number of trials."""
        return math.prod(self.sizes)

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """How many there are of each digit of a trial's number, the last the quickest."""
        repeats, detectors = self.spec.repeats, len(self.detectors)
        if self.sampled is not None:
            return (self.sampled.points, repeats, detectors)
        slow = [len(one.levels) for one in (*self.rendered, *self.mixed)]
        return (*slow, repeats, detectors, *(len(one.levels) for one in self.measured))

    @property
    def block(self) -> int:
        """How many trials in a row share their render, as far as the plan can tell."""
        if self.sampled is not None:
            return math.prod(self.sizes[1:]) if self.rendered else len(self)
        return math.prod(self.sizes[len(self.rendered) :])

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """All of them, slowest first."""
        return (*self.rendered, *self.mixed, *self.measured)

    @property
    def sampled(self) -> SampledSpec | None:
        """The design, if it is no grid."""
        return None if isinstance(self.spec.design, GridSpec) else self.spec.design

    @cached_property
    def _points(self) -> Any:
        if self.sampled is None:
            raise ValueError("a grid has no points")
        # In the file's order: what a field is rendered for may change with simtip's version.
        order = {paths: k for k, paths in enumerate(sorted(d.paths for d in self.dimensions))}
        spread = points(self.sampled, len(self.dimensions))
        return spread[:, [order[one.paths] for one in self.dimensions]]

    def trial(self, number: int) -> Trial:
        """Work out a trial."""
        digits = mixed_radix(number, self.sizes)
        if self.sampled is not None:
            point, repeat, detector = digits
            chosen = [
                one.at(float(share))
                for one, share in zip(self.dimensions, self._points[point], strict=True)
            ]
        else:
            slow = len(self.rendered) + len(self.mixed)
            repeat, detector = digits[slow : slow + 2]
            levels = digits[:slow] + digits[slow + 2 :]
            chosen = [one.levels[k] for one, k in zip(self.dimensions, levels, strict=True)]
        factors = {
            path: value
            for one, values in zip(self.dimensions, chosen, strict=True)
            for path, value in zip(one.paths, values, strict=True)
        }
        values = {path: value for path, value in factors.items() if not path.startswith(DETECT)}
        parameters = {
            path.removeprefix(DETECT): value
            for path, value in factors.items()
            if path.startswith(DETECT)
        }
        seen = self.detectors[detector].with_parameters(parameters)
        return Trial(number, values, repeat, seen, factors)

    def key(self, trial: Trial) -> str:
        """Give what tells a trial from any other, in any sweep of the same scene."""
        said = {path: trial.factors[path] for path in sorted(trial.factors)}
        # A design may come to the same values twice.
        point = [] if self.sampled is None else [trial.number // math.prod(self.sizes[1:])]
        return digest_of([self._root, said, trial.repeat, trial.measuring.identity, *point])[:32]

    @cached_property
    def _root(self) -> str:
        said = [self.base.model_dump(mode="json", exclude={"detect"}), self.seed]
        return digest_of([*said, self.spec.render_for] if self.spec.render_for else said)

    def code(self, variant: str) -> str:
        """Tell the code and the rig files that its trials run on from any other's."""
        code = code_digest({one.reference for one in self.detectors}, variant)
        rigs = {self.base.rig.measured}
        for one in self.dimensions:
            if MEASURED in one.paths:
                rigs |= {level[one.paths.index(MEASURED)] for level in one.levels}
        scenes = (self.scenes.with_values({MEASURED: path}) for path in rigs if path is not None)
        contents = sorted(rig_digest(measuring_rig(scene)) for scene in scenes)
        return digest_of([code, contents])[:16] if contents else code

    @property
    def digest(self) -> str:
        """Give what tells this plan's numbering of trials from another's."""
        levels = [[list(one.paths), one.levels, repr(one.span)] for one in self.dimensions]
        identities = [one.identity for one in self.detectors]
        design = self.spec.design.model_dump(mode="json")
        return digest_of([self._root, levels, self.spec.repeats, identities, design])

    def reference(self, trial: Trial) -> SceneSpec:
        """Give the scene that is rendered for a trial.

        It has the fields the light depends on, and of all others the values that ask for the least
        noise. So one render serves all lamp powers and exposures, whichever trial comes first.
        """
        rendered = {path for one in self.rendered for path in one.paths}
        kept = {path: value for path, value in trial.values.items() if path in rendered}
        shared = self._lit.with_values({**self._strictest, **kept})
        own = self.scenes.with_values(trial.values)
        # What a field means for the light may depend on another: a pinhole's aperture is nothing.
        return shared if light_digest(shared) == light_digest(own) else own

    @cached_property
    def _strictest(self) -> dict[str, Any]:
        """Of each factor that does not change the light, the level that asks for least noise."""
        chosen: dict[str, Any] = {}
        for one in self.mixed:
            tried = list(tried_levels(one))
            asked = [
                noise_asked(self.scenes.with_values(dict(zip(one.paths, level, strict=True))))
                for level in tried
            ]
            chosen |= dict(zip(one.paths, tried[int(np.argmin(asked))], strict=True))
        return chosen

    def columns(self) -> list[tuple[str, Kind]]:
        """Give name and kind ("int", "float", "text", "bool") of every factor's column."""
        found = []
        for one in self.dimensions:
            for k, path in enumerate(one.paths):
                seen: set[Kind | None] = {_kind(level[k]) for level in one.levels}
                if one.span is not None:
                    seen = {"int" if one.whole else "float"}
                found.append((path, _common(seen)))
        return found


def noise_asked(spec: SceneSpec) -> float:
    """Give the relative noise that a scene allows its render, where all its lamps shine."""
    allowed = noise_tolerance(spec)
    radiance = steady_weights(spec).sum(axis=0).astype(np.float32)
    if allowed is None or not radiance.any():
        return 1.0
    return float(allowed(radiance[None], radiance)[0] / radiance.mean())


def _kind(value: Any) -> Kind | None:
    if isinstance(value, bool):
        return "bool"
    if isinstance(value, int):
        return "int"
    return "float" if isinstance(value, float) else None if value is None else "text"


def _common(kinds: set[Kind | None]) -> Kind:
    known = {kind for kind in kinds if kind is not None}
    if len(known) == 1:
        return known.pop()
    return "float" if known == {"int", "float"} else "text"
