"""From a scene to a pair of images with their truth."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.exposure import background_irradiance, settle_exposure, settle_white_balance
from simtip.geometry import Array
from simtip.light_inputs import first_difference
from simtip.mix import weights
from simtip.noise_budget import noise_tolerance
from simtip.optics import expose_lens
from simtip.render import Backend, Progress, View, choose, render_pair
from simtip.seeding import stream
from simtip.sensor import Image, expose, fixed_pattern
from simtip.spec import SceneSpec, SensorSpec
from simtip.truth import SceneTruth, scene_truth

Level = Callable[[NDArray[np.float32], View], Array]
"""From irradiance on a sensor (H, W, 3) and its view to that of what is to be exposed for, (3,)."""


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
    light_seed
        The root seed of what was rendered: its samples, its clutter and paper.
    timings_s
        Wall time of "render", if it was rendered here, and "sensor".
    """

    spec: SceneSpec
    seed: int
    backend: Backend
    truth: SceneTruth
    views: tuple[View, View]
    images: tuple[Image, Image]
    timings_s: dict[str, float]
    light_seed: int


def simulate(
    spec: SceneSpec,
    *,
    seed: int | None = None,
    backend: Backend | None = None,
    progress: Progress | None = None,
    noise_seed: int | None = None,
    light: SceneSpec | None = None,
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
    noise_seed
        Of the sensors' noise alone, if it is not `seed`: so a sweep draws it.
    light
        The scene that the light is rendered for, if it is not this one: a sweep renders for the
        least noise that any of its trials asks for.

    Raises
    ------
    InputError
        The scene has no meaningful truth, e.g. the needle is outside both images, or no exposure
        gives `sensor.background_dn`; or `light` is lit otherwise: `field` says by what.
    """
    seed = spec.seed if seed is None else seed
    rendered_for = spec if light is None else light
    _require_same_light(spec, rendered_for)
    scene_truth(spec)  # before long work: what has no truth is refused
    backend = backend or choose()
    start = time.perf_counter()
    views = render_pair(
        rendered_for,
        backend=backend,
        seed=seed,
        tolerance=noise_tolerance(rendered_for),
        progress=progress,
    )
    rendered = time.perf_counter() - start
    noise = seed if noise_seed is None else noise_seed
    done = expose_pair(spec, views, seed=noise, backend=backend, light_seed=seed)
    return replace(done, timings_s={"render": rendered, **done.timings_s})


def _require_same_light(spec: SceneSpec, light: SceneSpec) -> None:
    same_seed = light.model_copy(update={"seed": spec.seed})
    field = first_difference(same_seed, spec)
    if field is not None:
        raise InputError(
            "differs from the scene that the light is to be rendered for, and the light depends "
            "on it",
            field=field,
            remedy="give both scenes the same",
        )


def expose_pair(
    spec: SceneSpec,
    views: tuple[View, View],
    *,
    seed: int,
    backend: Backend,
    light_seed: int | None = None,
) -> Simulation:
    """Mix rendered light and expose both sensors to it: nothing is rendered.

    Parameters
    ----------
    spec
        The scene; `simtip.light_inputs` says what of it has to be as it was rendered.
    views
        Left and right.
    seed
        Root seed of the sensors' noise.
    backend
        What rendered them.
    light_seed
        The root seed they were rendered with, if it is not `seed`.

    Raises
    ------
    InputError
        The scene has no meaningful truth, or no exposure gives `sensor.background_dn`.
    """
    truth = scene_truth(spec)
    start = time.perf_counter()
    spec, images = expose_views(spec, views, seed=seed, level=_open_background)
    timings = {"sensor": time.perf_counter() - start}
    rendered = seed if light_seed is None else light_seed
    return Simulation(spec, seed, backend, truth, views, images, timings, rendered)


def expose_views(
    spec: SceneSpec, views: tuple[View, View], *, seed: int, level: Level
) -> tuple[SceneSpec, tuple[Image, Image]]:
    """Expose both sensors to rendered light.

    Parameters
    ----------
    spec
        The scene.
    views
        Left and right.
    seed
        Root seed of the sensors' noise.
    level
        What counts as background for auto-exposure and white balance.

    Returns
    -------
    spec, images
        The scene with the exposure found, and both images, DN.

    Raises
    ------
    InputError
        No exposure gives `sensor.background_dn`.
    """
    cameras = (spec.rig.left, spec.rig.right)
    light = _Light(spec, views, level)
    sensor = settle_white_balance(light.backgrounds, spec.sensor)
    spec = spec.model_copy(update={"sensor": settle_exposure(light.backgrounds, sensor)})
    left, right = (
        expose(
            irradiance,
            spec.sensor,
            camera=fixed_pattern(spec.sensor, camera, side),
            rng=stream(seed, side, "sensor"),
        )
        for side, irradiance, camera in zip(
            ("left", "right"), light.on_sensors(spec.sensor), cameras, strict=True
        )
    )
    return spec, (left, right)


def _open_background(irradiance: NDArray[np.float32], view: View) -> Array:
    return background_irradiance(irradiance, np.maximum(view.coverage, view.clutter))


class _Light:
    """What falls on both sensors; mixed again only if another exposure changes it (ripple)."""

    def __init__(self, spec: SceneSpec, views: tuple[View, View], level: Level) -> None:
        self._spec, self._views, self._level = spec, views, level
        self._weights: list[Array] = []
        self._irradiance: list[NDArray[np.float32]] = []

    def on_sensors(self, sensor: SensorSpec) -> list[NDArray[np.float32]]:
        """Give the irradiance of the left and the right sensor, (H, W, 3) W m^-2."""
        spec = self._spec.model_copy(update={"sensor": sensor})
        new = [
            power for view in self._views for power in weights(spec, len(view.coverage)).values()
        ]
        if not self._irradiance or not all(map(np.array_equal, new, self._weights)):
            self._weights = new
            self._irradiance = [
                expose_lens(view.radiance(spec), camera.camera(), camera.lens, sensor)
                for view, camera in zip(self._views, (spec.rig.left, spec.rig.right), strict=True)
            ]
        return self._irradiance

    def backgrounds(self, sensor: SensorSpec) -> Array:
        """Give the irradiance of both backgrounds, (2, 3) W m^-2."""
        levels = [
            self._level(light, view)
            for light, view in zip(self.on_sensors(sensor), self._views, strict=True)
        ]
        return np.array(levels)
