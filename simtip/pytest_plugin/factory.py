"""The fixture `simtip_pair`: a scene, a seed and perhaps changes in, a pair out."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from simtip.errors import InputError
from simtip.pytest_plugin.one_line import in_one_line
from simtip.pytest_plugin.pair import Pair
from simtip.pytest_plugin.places import Places
from simtip.pytest_plugin.seeds import noise_seed, require_seed
from simtip.pytest_plugin.suites import scene_of_case
from simtip.pytest_plugin.used import Used, used_by
from simtip.pytest_plugin.workshop import Workshop, workshop_of
from simtip.regress.suite import STANDARD
from simtip.scene_file import load_scene
from simtip.spec import SceneSpec
from simtip.spec.scene import DetectSpec
from simtip.sweep.assignment import Scenes, require_plain
from simtip.sweep.plan import Plan
from simtip.sweep.spec import MEASURED, SweepSpec


class PairFactory:
    """Makes pairs of images for one test.

    Parameters
    ----------
    workshop
        The session's.
    places
        From where files count.
    used
        Remembers the pairs.
    """

    def __init__(self, workshop: Workshop, places: Places, used: Used) -> None:
        self._workshop, self._places, self._used = workshop, places, used

    def __call__(
        self,
        scene: str | Path | SceneSpec,
        seed: int | None = None,
        changes: Mapping[str, Any] | None = None,
        **fields: Any,
    ) -> Pair:
        """Give a pair of images of a scene.

        Parameters
        ----------
        scene
            A scene's file, which counts from the folder of the test's file or else from the root
            folder of the tests; a scene; or ``standard:NAME``, a case of the standard suite.
        seed
            Of the sensors' noise; by default the scene's. The light is rendered with the scene's
            own, so that all seeds share it.
        changes, fields
            Fields of the scene that are other than in its file, dotted:
            ``{"sensor.exposure_s": 0.02}``.
        """
        __tracebackhide__ = True
        with in_one_line():
            pair = self._made(scene, seed, {**_by_path(changes), **fields})
        self._used.note(pair)
        return pair

    def _made(
        self, scene: str | Path | SceneSpec, seed: int | None, changes: Mapping[str, Any]
    ) -> Pair:
        own = None if seed is None else require_seed(seed, "seed")
        name, spec = self._scene(scene, {path: self._plain(path, v) for path, v in changes.items()})
        # Images are the same whatever looks for the tip in them; a scene's may be code, too.
        plain = spec.model_copy(update={"detect": DetectSpec()})
        fresh = self._workshop.seed
        plan = Plan(SweepSpec(scene=name, seed=noise_seed(own, fresh)), plain, name=name)
        setting, shot = self._workshop.make(plan, plan.trial(0))
        said = [name]
        said += [] if own is None else [f"seed {own}"]
        said += [] if fresh is None else [f"noise anew ({fresh})"]
        return Pair(", ".join(said), spec, setting, shot, self._used)

    def _scene(
        self, scene: str | Path | SceneSpec, changes: Mapping[str, Any]
    ) -> tuple[str, SceneSpec]:
        """Give the scene, and what it is called."""
        require_plain(changes)
        if isinstance(scene, SceneSpec):
            return scene.name, Scenes(scene, scene.name).with_values(changes)
        if isinstance(scene, str) and scene.startswith(f"{STANDARD}:"):
            case = scene.partition(":")[2]
            return case, scene_of_case(case, changes)
        if not isinstance(scene, str | Path):
            raise InputError(
                f"a scene is a file, a SceneSpec or {STANDARD}:NAME, not {type(scene).__name__}",
                remedy="give one of them",
            )
        path = self._places.find(scene, "scene")
        return path.stem, Scenes(load_scene(path), str(path)).with_values(changes)

    def _plain(self, name: str, value: Any) -> Any:
        """Give a value as a scene's file would have it."""
        if name == MEASURED and isinstance(value, str | Path):
            return str(self._places.find(value, "rig"))
        try:
            return json.loads(json.dumps(value, default=lambda one: one.tolist()))
        except (TypeError, ValueError, AttributeError):
            raise InputError(
                f"is of the type {type(value).__name__}, which no scene's file can hold",
                field=name,
                remedy="give numbers, texts, lists and mappings",
            ) from None


def _by_path(changes: object) -> dict[str, Any]:
    """Give changes as a test has said them."""
    if changes is None:
        return {}
    if not isinstance(changes, Mapping) or not all(isinstance(path, str) for path in changes):
        raise InputError(
            f"is {reprlib.repr(changes)}",
            field="changes",
            remedy="give fields with their values, as {'sensor.exposure_s': 0.02}",
        )
    return dict(changes)


def factory_for(request: pytest.FixtureRequest) -> PairFactory:
    """Give what makes the pairs of a test."""
    with in_one_line():
        workshop = workshop_of(request.config)
    return PairFactory(workshop, Places.of(request.node, request.config), used_by(request))
