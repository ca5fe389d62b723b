"""A row's trial once more: the scene it was of, its images, and how to run it again.

Neither a detector nor a program that the sweep names is imported or started for it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pydantic import ValidationError

from simtip.errors import InputError, SimtipError
from simtip.light_file import lights_name, read_lights
from simtip.light_inputs import first_difference
from simtip.noise_budget import noise_tolerance
from simtip.render import Backend, Progress, View, choose, render_pair
from simtip.render.backend import VARIANTS
from simtip.simulation import expose_pair
from simtip.spec import SceneSpec
from simtip.spec.scene import DetectSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.cache import Cache
from simtip.sweep.columns import Kind
from simtip.sweep.detectors import Measuring
from simtip.sweep.plan import Plan, Trial
from simtip.sweep.rows import cell_of
from simtip.sweep.shots import SIDES, Shot, read_shot
from simtip.sweep.spec import DetectorEntry, RangeSpec, SweepSpec
from simtip.sweep.stage_keys import image_inputs, image_key, light_key
from simtip.sweep.stages import IMAGES, LIGHT
from simtip.sweep.table import Table
from simtip.sweep.varying import DETECT


@dataclass(frozen=True)
class Again:
    """A row's trial.

    Attributes
    ----------
    scene
        What it was of, with its detector.
    light
        The scene that its light was rendered for; None if that is the same.
    noise_seed
        Of its sensors' noise; None if the trial had none: it could not be.
    same_light
        Whether light and images come out as they did: by the code that is installed, they have the
        keys that the row tells.
    """

    scene: SceneSpec
    light: SceneSpec | None
    noise_seed: int | None
    same_light: bool


class Remaking:
    """Makes trials of a table again.

    Parameters
    ----------
    table
        A sweep's.
    cache
        Where their images may still be; None for none.
    backend
        What renders where they are not; None is the best there is.

    Raises
    ------
    InputError
        The table does not say what its sweep was.
    """

    def __init__(self, table: Table, cache: Cache | None, backend: str | None = None) -> None:
        self._cache, self._backend_name = cache, backend
        self._kinds: dict[str, Kind] = {column.name: column.kind for column in table.columns}
        try:
            self.sweep = SweepSpec.model_validate_json(table.provenance["sweep"], strict=True)
            base = SceneSpec.model_validate_json(table.provenance["scene"], strict=True)
        except (KeyError, TypeError, ValidationError, InputError) as error:
            raise InputError(
                "does not tell the sweep that it is of",
                file=table.folder / "table.json",
                remedy="run the sweep again with this version of simtip",
            ) from error
        self.scenes = Scenes(base)

    def again(self, row: Mapping[str, Any]) -> Again:
        """Give a row's trial.

        Raises
        ------
        InputError
            Its values make no scene.
        """
        values = self._values(row)
        scene = self.scenes.with_values(
            {path: value for path, value in values.items() if not path.startswith(DETECT)}
        )
        lit = self._light_of(values, scene, int(row["repeat"]))
        scene = scene.model_copy(update={"detect": self._detector(row, values)})
        seed = row.get("noise_seed")
        same = first_difference(lit, scene) is None and _alike(lit, scene)
        return Again(
            scene,
            None if same else lit,
            None if seed is None else int(seed),
            self._keys(lit, scene, seed) == (row.get("light_key"), row.get("image_key")),
        )

    def images(
        self, row: Mapping[str, Any], trial: Again, progress: Progress | None = None
    ) -> Shot | None:
        """Give a row's images, from the cache or made anew; None if it had none.

        Raises
        ------
        SimtipError
            They cannot be made.
        """
        kept = self._entry(IMAGES, row.get("image_key"))
        shot = None if kept is None else read_shot(kept)
        if shot is not None or trial.noise_seed is None:
            return shot
        lit = trial.light or trial.scene
        views = self._views(row.get("light_key"), lit, progress)
        done = expose_pair(
            trial.scene, views, seed=trial.noise_seed, backend=self._backend, light_seed=lit.seed
        )
        return Shot(done.images, done.spec.sensor.exposure_s)

    def _views(self, key: object, lit: SceneSpec, progress: Progress | None) -> tuple[View, View]:
        kept = self._entry(LIGHT, key)
        if kept is not None:
            try:
                left, right = (read_lights(kept / lights_name(side)).view for side in SIDES)
            except InputError:
                pass  # cut short, or evicted meanwhile
            else:
                return left, right
        if self._lit is None or self._lit[0] != lit:
            made = render_pair(
                lit,
                backend=self._backend,
                seed=lit.seed,
                tolerance=noise_tolerance(lit),
                progress=progress,
            )
            self._lit = lit, made
        return self._lit[1]

    _lit: tuple[SceneSpec, tuple[View, View]] | None = None
    """What was rendered last: the worst trials are often of one light."""

    def _entry(self, kind: str, key: object) -> Any:
        if self._cache is None or not isinstance(key, str):
            return None
        try:
            return self._cache.entry(kind, key)
        except ValueError:  # the table is not simtip's own any more
            return None

    @cached_property
    def _backend(self) -> Backend:
        return choose(self._backend_name)

    def _keys(self, lit: SceneSpec, scene: SceneSpec, seed: object) -> tuple[str, str] | None:
        if not isinstance(seed, int):
            return None
        light = light_key(lit, self._variant)
        return light, image_key(light, image_inputs(scene), seed)

    @cached_property
    def _variant(self) -> str:
        try:
            return self._backend.variant
        except SimtipError:  # nothing renders here; what is in the cache can still be shown
            return VARIANTS["llvm"]

    def _values(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Give the values of a row's factors as the sweep file has them."""
        found = {}
        for path, levels in self._levels():
            cell = row.get(path)
            kind = self._kinds.get(path, "text")
            known = [value for value in levels if cell_of(value, kind) == cell]
            found[path] = known[0] if known else cell
        return found

    def _levels(self) -> Iterator[tuple[str, list[Any]]]:
        for path, given in self.sweep.factors.items():
            yield path, [] if isinstance(given, RangeSpec) else given
        for group in self.sweep.zipped:
            yield from group.items()

    def _detector(self, row: Mapping[str, Any], values: Mapping[str, Any]) -> DetectSpec:
        """Give a row's detector and how it was set.

        A program's own parameters are nobody's business here: a factor counts for it, too.
        """
        own = self.scenes.base.detect
        for entry in self.sweep.detectors or [own.name]:
            given = DetectorEntry(name=entry) if isinstance(entry, str) else entry
            if (given.label or given.name) == row.get("detector"):
                break
        else:
            given = DetectorEntry(name=own.name)
        kept = own.parameters() if given.name == own.name else {}
        asked = {p.removeprefix(DETECT): v for p, v in values.items() if p.startswith(DETECT)}
        one = Measuring(given.name, given.name, {**kept, **given.parameters()})
        if one.is_own:
            one = one.with_parameters(asked)
        else:
            asked = {name: value for name, value in asked.items() if value is not None}
            one = Measuring(one.label, one.reference, {**one.parameters, **asked})
        return one.spec

    @cached_property
    def _plan(self) -> Plan:
        """The sweep as far as it is rendered: without what its detectors are set to."""
        kept = {path: f for path, f in self.sweep.factors.items() if not path.startswith(DETECT)}
        zipped = [
            {path: levels for path, levels in group.items() if not path.startswith(DETECT)}
            for group in self.sweep.zipped
        ]
        spec = self.sweep.model_copy(
            update={
                "factors": kept,
                "zipped": [_distinct(group) for group in zipped if group],
                "detectors": ["lin2020"],
            }
        )
        data = self.scenes.base.model_dump(mode="json", exclude_unset=True)
        data.pop("detect", None)
        return Plan(spec, SceneSpec.model_validate_json(json.dumps(data), strict=True))

    def _light_of(self, values: Mapping[str, Any], own: SceneSpec, repeat: int) -> SceneSpec:
        of_scene = {path: v for path, v in values.items() if not path.startswith(DETECT)}
        try:
            plan = self._plan
            trial = Trial(0, of_scene, repeat, plan.detectors[0], of_scene)
            lit = plan.reference(trial)
        except InputError:
            return own
        return lit.model_copy(update={"detect": own.detect, "name": own.name})


def _distinct(group: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Leave out levels that only a detector's parameters told apart."""
    levels = list(dict.fromkeys(json.dumps(level) for level in zip(*group.values(), strict=True)))
    columns = zip(*map(json.loads, levels), strict=True)
    return {path: list(column) for path, column in zip(group, columns, strict=True)}


def _alike(lit: SceneSpec, scene: SceneSpec) -> bool:
    """Say whether a scene asks for the light that was rendered: as little noise, as much power."""
    return light_key(lit, "") == light_key(scene, "")
