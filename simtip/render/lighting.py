"""The light on matt surfaces, mapped beforehand: the background's, and a calibration board's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array
from simtip.mix import steady_weights
from simtip.render.illuminator import Illuminator, Surface
from simtip.render.lightmap import COARSE_STEP_MM, Lack, LightMap, light_map, limited_step
from simtip.render.progress import Tally
from simtip.render.view import Floats, Tolerance
from simtip.render.world import World
from simtip.seeding import seed32
from simtip.spec import SceneSpec

FINE_POINTS_MAX = 2_000_000
COARSE_POINTS_MAX = 50_000
MIRRORED_EFFORT = 1 / 8


@dataclass(frozen=True, eq=False)
class Lighting:
    """Maps light on surfaces of a world, as free of noise as is asked.

    Attributes
    ----------
    spec, world
        The scene.
    seed
        Of the samples.
    tally
        Told what is planned and done.
    tolerance
        How noisy pixels may be; None: whatever comes.
    """

    spec: SceneSpec
    world: World
    seed: int
    tally: Tally
    tolerance: Tolerance | None

    def on(self, surface: Surface, low: Array, high: Array, step: float, albedo: Array) -> LightMap:
        """Map the light on a surface before which nothing stands.

        Parameters
        ----------
        surface
            With coordinates of its own.
        low, high
            (2,) corners of the box to map, mm.
        step
            Of the map, mm.
        albedo
            (3,) of the surface.
        """
        light = Illuminator(None, self.world.lamps, self.world.surround, surface, 0.0)
        step = limited_step(low, high, step, COARSE_POINTS_MAX)
        seed = seed32(self.seed, "light", "subject")
        return light_map(light, low, high, step, seed, self.tally, lack=self._lack(albedo))

    def on_background(self, low: Array, high: Array) -> tuple[LightMap, LightMap]:
        """Map the part of the background in view finely and all of it coarsely, for mirror images.

        Parameters
        ----------
        low, high
            (2,) corners of the part in view, mm.
        """
        spec, world = self.spec, self.world
        height = 0.0 if world.clutter else self._subject_height_mm()
        light = Illuminator(world.scene, world.lamps, world.surround, world.board, height)
        half = world.board.half
        step = limited_step(low, high, spec.render.light_step_mm, FINE_POINTS_MAX)
        lack = self._lack(np.array(spec.background.albedo))
        fine = light_map(
            light, low, high, step, seed32(self.seed, "light", "fine"), self.tally, lack=lack
        )
        coarse_step = min(COARSE_STEP_MM, float(2 * half.min()) / 4)
        coarse_step = limited_step(-half, half, coarse_step, COARSE_POINTS_MAX)
        coarse = light_map(
            light.without_shadows() if spec.render.crop else light,
            -half,
            half,
            coarse_step,
            seed32(self.seed, "light", "coarse"),
            self.tally,
            room_effort=MIRRORED_EFFORT,
        )
        return fine, coarse

    def _lack(self, albedo: Array) -> Lack | None:
        """Say how a map's noise, once mixed and off a surface, compares with what is allowed."""
        if self.tolerance is None:
            return None
        tolerance = self.tolerance
        power = steady_weights(self.spec).astype(np.float32)
        colour = albedo.astype(np.float32)

        def lack(light: Floats, sd: Floats) -> Floats:
            mixed = (light.reshape(-1, len(power)) @ power) * colour
            noise = np.sqrt((sd.reshape(-1, len(power)) ** 2) @ (power.mean(axis=1) ** 2))
            allowed = np.maximum(tolerance(mixed, np.median(mixed, axis=0)), np.float32(1e-30))
            found: Floats = (noise * colour.mean() / allowed).reshape(sd.shape[:2])
            return found

        return lack

    def _subject_height_mm(self) -> float:
        """Give how far off the background the subject's nearest point is."""
        board = self.world.board
        return float(((self.world.subject.vertices() - board.centre) @ board.normal).min())
