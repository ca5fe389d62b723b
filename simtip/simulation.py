"""From a scene to a pair of images with their truth."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from simtip.exposure import auto_expose, background_irradiance
from simtip.optics import expose_lens
from simtip.render import Backend, Progress, View, choose, render_pair
from simtip.seeding import stream
from simtip.sensor import Image, expose, fixed_pattern
from simtip.spec import SceneSpec
from simtip.truth import SceneTruth, scene_truth


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated pair of images and what is true of it.

    Attributes
    ----------
    spec, seed, backend
        What was simulated, and how; with auto-exposure, the spec has the exposure time found.
    truth
        Where the tip really is.
    views
        Left and right, as light per lamp, with needle coverage and depth.
    images
        Left and right, (H, W, 3) RGB, DN; uint8 at 8 bit, uint16 above.
    timings_s
        Wall time of "render" and "sensor".
    """

    spec: SceneSpec
    seed: int
    backend: Backend
    truth: SceneTruth
    views: tuple[View, View]
    images: tuple[Image, Image]
    timings_s: dict[str, float]


def simulate(
    spec: SceneSpec,
    *,
    seed: int | None = None,
    backend: Backend | None = None,
    progress: Progress | None = None,
) -> Simulation:
    """Render a scene and expose both sensors.

    Parameters
    ----------
    spec
        The scene.
    seed
        Root of all random numbers; by default the scene's own. Each camera and stage draws from a
        stream of its own.
    backend
        What renders; by default what `simtip.render.choose` finds.
    progress
        Called with the fraction rendered.

    Raises
    ------
    InputError
        The scene has no meaningful truth, e.g. the needle is outside both images.
    """
    seed = spec.seed if seed is None else seed
    truth = scene_truth(spec)
    backend = backend or choose()
    start = time.perf_counter()
    views = render_pair(spec, backend=backend, seed=seed, progress=progress)
    rendered = time.perf_counter()
    cameras = (spec.rig.left, spec.rig.right)
    lights = [
        expose_lens(view.radiance(spec), camera.camera(), camera.lens, spec.sensor)
        for view, camera in zip(views, cameras, strict=True)
    ]
    if spec.sensor.background_dn is not None:
        levels = [
            background_irradiance(light, view.coverage)
            for light, view in zip(lights, views, strict=True)
        ]
        sensor = auto_expose(np.mean(levels, axis=0), spec.sensor)
        spec = spec.model_copy(update={"sensor": sensor})
    left, right = (
        expose(
            light,
            spec.sensor,
            camera=fixed_pattern(spec.sensor, camera, side),
            rng=stream(seed, side, "sensor"),
        )
        for side, light, camera in zip(("left", "right"), lights, cameras, strict=True)
    )
    timings = {"render": rendered - start, "sensor": time.perf_counter() - rendered}
    return Simulation(spec, seed, backend, truth, views, (left, right), timings)
