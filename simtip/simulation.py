"""From a scene to a pair of images with their truth."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.render import Backend, Progress, View, choose, render_pair
from simtip.seeding import stream
from simtip.sensor import expose
from simtip.spec import SceneSpec
from simtip.truth import SceneTruth, scene_truth


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated pair of images and what is true of it.

    Attributes
    ----------
    spec, seed, backend
        What was simulated, and how.
    truth
        Where the tip really is.
    views
        Left and right, as light per lamp, with needle coverage and depth.
    images
        Left and right, (H, W, 3) uint8 RGB, DN.
    timings_s
        Wall time of "render" and "sensor".
    """

    spec: SceneSpec
    seed: int
    backend: Backend
    truth: SceneTruth
    views: tuple[View, View]
    images: tuple[NDArray[np.uint8], NDArray[np.uint8]]
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
    left, right = (
        expose(view.radiance(spec), spec.sensor, stream(seed, side, "sensor"))
        for side, view in zip(("left", "right"), views, strict=True)
    )
    timings = {"render": rendered - start, "sensor": time.perf_counter() - rendered}
    return Simulation(spec, seed, backend, truth, views, (left, right), timings)
