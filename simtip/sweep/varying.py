"""What varies in a sweep: tried before anything runs, and sorted by the stage that it changes."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.errors import InputError
from simtip.light_inputs import light_digest
from simtip.measuring_rig import measuring_rig
from simtip.sweep.assignment import Scenes, require_plain
from simtip.sweep.detectors import Measuring
from simtip.sweep.levels import Dimension, values_of
from simtip.sweep.spec import GridSpec, RangeSpec, SweepSpec
from simtip.sweep.stage_keys import digest_of
from simtip.yaml_file import undotted

DETECT = "detect."
NOT_RENDERED = ("match", "triangulate", "refine", "rig.measured", "name")
"""Fields that count after the images only."""

MOST_CHECKED = 200
"""Levels of a factor that are tried before a sweep begins; of more, these many, spread."""

MOST_TRIALS = 10**12


@dataclass(frozen=True)
class Varying:
    """The dimensions of a sweep, by the first stage that each changes."""

    light: tuple[Dimension, ...]
    images: tuple[Dimension, ...]
    measurement: tuple[Dimension, ...]


def varying(spec: SweepSpec, scenes: Scenes, detectors: tuple[Measuring, ...]) -> Varying:
    """Try and sort what varies.

    Parameters
    ----------
    spec
        The sweep.
    scenes
        Makes its scenes.
    detectors
        Its detectors.

    Raises
    ------
    InputError
        A field or a parameter does not exist, or a value does not fit.
    """
    return _Sorter(spec, scenes, detectors).sorted()


def tried_levels(one: Dimension) -> Iterator[tuple[Any, ...]]:
    """Give a dimension's levels, a few of many; of a range, its ends."""
    if one.span is not None:
        yield one.at(0.0)
        yield one.at(1 - 1e-12)
        return
    few = min(len(one.levels), MOST_CHECKED)
    for k in np.unique(np.linspace(0, len(one.levels) - 1, few).round().astype(int)):
        yield one.levels[k]


class _Sorter:
    def __init__(self, spec: SweepSpec, scenes: Scenes, detectors: tuple[Measuring, ...]) -> None:
        self._spec, self._scenes, self._detectors = spec, scenes, detectors

    def sorted(self) -> Varying:
        made = [self._dimension(path, given) for path, given in self._spec.factors.items()]
        made += [
            Dimension(tuple(group), tuple(zip(*group.values(), strict=True)))
            for group in self._spec.zipped
            if group
        ]
        require_plain([path for one in made for path in one.paths])
        by_stage: dict[str, list[Dimension]] = {"light": [], "images": [], "measure": []}
        for one in made:
            self._check(one)
            _require_distinct(one)
            by_stage[self._stage(one)].append(one)
        total = math.prod([max(len(one.levels), 1) for one in made])
        if total * self._spec.repeats * len(self._detectors) > MOST_TRIALS:
            raise InputError(
                f"makes more than {MOST_TRIALS:.0e} trials", field="factors", remedy="vary less"
            )
        return Varying(*(tuple(found) for found in by_stage.values()))

    def _dimension(self, path: str, given: RangeSpec | list[Any]) -> Dimension:
        if isinstance(given, list):
            return Dimension((path,), tuple((value,) for value in given))
        whole = self._whole(path)
        if given.count is None and given.step is None:
            if isinstance(self._spec.design, GridSpec):
                raise InputError(
                    "says neither count nor step", field=path, remedy="add count, or a design"
                )
            return Dimension((path,), (), given, whole)
        return Dimension((path,), tuple((value,) for value in values_of(given, whole=whole)))

    def _whole(self, path: str) -> bool:
        """Say whether a field takes whole numbers only."""
        if path.startswith(DETECT):
            name = path.removeprefix(DETECT)
            types = [one.type_of(name) for one in self._detectors]
            return any(kind.split(" ")[0] == "int" for kind in types if kind)
        value = self._scenes.value(path)
        return isinstance(value, int) and not isinstance(value, bool)

    def _check(self, one: Dimension) -> None:
        """Try every level on its own."""
        for level in tried_levels(one):
            values = dict(zip(one.paths, level, strict=True))
            scene = _of_scene(values)
            for path in ("detect", "detect.name"):
                if path in values:
                    raise InputError(
                        "is varied by detectors", field=path, remedy="list them in detectors"
                    )
            if scene:
                self._check_scene(scene)
            asked = {p.removeprefix(DETECT): v for p, v in values.items() if p.startswith(DETECT)}
            for name, value in asked.items():
                self._check_parameter(name, value)

    def _check_scene(self, values: dict[str, Any]) -> None:
        try:
            measuring_rig(self._scenes.with_values(values))
        except InputError as error:
            if error.file is not None or error.field is None or _is_about(error.field, values):
                raise
            # What else the scene says is right: it was read.
            raise InputError(
                f"does not go with {error.field}: {error.problem}",
                field=next(iter(values)),
                remedy=error.remedy,
            ) from error

    def _check_parameter(self, name: str, value: object) -> None:
        taking = [one for one in self._detectors if one.type_of(name) is not None]
        if not taking:
            known = sorted({p for one in self._detectors for p in one.declared})
            raise InputError(
                "is no parameter of the sweep's detectors",
                field=f"{DETECT}{name}",
                remedy=_nearest(name, known),
            )
        for one in taking:
            one.with_parameters({name: value}).configured(self._scenes.base)

    def _stage(self, one: Dimension) -> str:
        if all(path.startswith((DETECT, *NOT_RENDERED)) for path in one.paths):
            return "measure"
        if any(path.split(".")[0] == "render" for path in one.paths):
            return "light"
        base = light_digest(self._scenes.base)
        for level in tried_levels(one):
            scene = _of_scene(dict(zip(one.paths, level, strict=True)))
            if light_digest(self._scenes.with_values(scene)) != base:
                return "light"
        return "images"


def _of_scene(values: dict[str, Any]) -> dict[str, Any]:
    return {path: value for path, value in values.items() if not path.startswith(DETECT)}


def _is_about(field: str, paths: Iterable[str]) -> bool:
    """Say whether a field is one of these, or lies around or within one."""
    wanted = undotted(field)
    pairs = (zip(wanted, undotted(path), strict=False) for path in paths)
    return any(all(one == other for one, other in pair) for pair in pairs)


def _require_distinct(one: Dimension) -> None:
    """Refuse levels of which two are equal: their trials would be one.

    Raises
    ------
    InputError
        Two are; it names the field.
    """
    seen = set()
    for level in one.levels:
        said = digest_of(list(level))
        if said in seen:
            again = level[0] if len(level) == 1 else list(level)
            raise InputError(
                f"has {str(again)[:60]} twice", field=one.paths[0], remedy="name each value once"
            )
        seen.add(said)


def _nearest(name: str, known: list[str]) -> str:
    close = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {DETECT}{close[0]}?" if close else f"known: {', '.join(known)}"
