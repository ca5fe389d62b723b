"""The images of a condition, the same ones for every method."""

from __future__ import annotations

import zlib
from functools import cached_property
from pathlib import Path

from detector_conditions import Condition
from detector_methods import Images
from light_cache import rendered

from simtip import SceneSpec
from simtip.render import Backend, View, choose
from simtip.seeding import seed32
from simtip.simulation import expose_pair


class Shots:
    """Renders each scene of a condition once, when it is first asked for, and exposes it anew.

    Parameters
    ----------
    condition
        Which.
    cache
        Folder in which rendered light is kept.
    one_camera
        Whether all exposures of a pose are by the same pair of cameras, or each by its own.
    """

    def __init__(
        self, condition: Condition, cache: Path | None, *, one_camera: bool = False
    ) -> None:
        self.condition = condition
        self._cache, self._one_camera = cache, one_camera
        self._views: dict[int, tuple[View, View]] = {}

    @cached_property
    def scenes(self) -> list[SceneSpec]:
        """The condition's scenes, one a pose."""
        return self.condition.scenes()

    @cached_property
    def backend(self) -> Backend:
        """What renders."""
        return choose()

    def images(self, pose: int, exposure: int) -> Images:
        """Give a pair; its noise depends on the condition's name and these numbers alone.

        Cameras have a fixed pattern of their own: in one picture it is noise.
        """
        if pose not in self._views:
            self._views[pose] = rendered(self.scenes[pose], self.backend, self._cache)
        scene, name = self.scenes[pose], self.condition.name
        seed = seed32(zlib.crc32(name.encode()), "exposure", pose, exposure)
        camera = seed32(zlib.crc32(name.encode()), "camera", pose) if self._one_camera else seed
        sensor = scene.sensor.model_copy(update={"fixed_pattern_seed": camera})
        shot = expose_pair(
            scene.model_copy(update={"sensor": sensor}),
            self._views[pose],
            seed=seed,
            backend=self.backend,
            light_seed=scene.seed,
        )
        left, right = shot.images
        stored = self.condition.stored
        return (left, right) if stored is None else (stored(left), stored(right))
