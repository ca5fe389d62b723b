"""Rendered light, kept between runs: it does not depend on who looks at it."""

from __future__ import annotations

from pathlib import Path

from simtip import SceneSpec
from simtip.light_file import Lights, lights_name, read_lights, write_lights
from simtip.light_inputs import light_digest
from simtip.noise_budget import noise_tolerance
from simtip.render import Backend, View, render_pair

SIDES = ("left", "right")


def rendered(scene: SceneSpec, backend: Backend, folder: Path | None) -> tuple[View, View]:
    """Render a scene with its own seed, or take its light from a folder if it lies there.

    Scenes that differ in sensor, lamp powers or all else that is mixed later share their light.
    """
    if folder is None:
        return _render(scene, backend)
    place = folder / f"{light_digest(scene)}-{scene.render.noise}-{backend.variant}"
    files = [place / lights_name(side) for side in SIDES]
    if not all(file.exists() for file in files):
        place.mkdir(parents=True, exist_ok=True)
        views = _render(scene, backend)
        for side, view, file in zip(SIDES, views, files, strict=True):
            write_lights(file, Lights(view, scene, scene.seed, side))
        return views
    left, right = (read_lights(file).view for file in files)
    return left, right


def _render(scene: SceneSpec, backend: Backend) -> tuple[View, View]:
    tolerance = noise_tolerance(scene)
    return render_pair(scene, backend=backend, seed=scene.seed, tolerance=tolerance)
