"""Light samples from points of a matt surface to the lamps and the room."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.render.chunks import batches, means
from simtip.render.engine import dr, mi
from simtip.render.illumination import direct, matt_point, room_ray
from simtip.render.lamps import Lamp
from simtip.render.progress import Tally
from simtip.render.sobol import Points, points_of
from simtip.render.sobol_table import TABLE_POINTS
from simtip.render.surround import Surround
from simtip.seeding import seed32

Floats = NDArray[np.float32]


class Surface(Protocol):
    """Something matt, with coordinates (s, t), mm, of its own."""

    def points(self, st: Array) -> Array:
        """World points (n, 3), mm, of coordinates (n, 2)."""

    def normals(self, st: Array) -> Array:
        """World unit normals (n, 3), likewise."""


class Illuminator:
    """Sends light samples from points of a surface to the lamps and the room.

    `height_mm` is how far off the surface the nearest thing is that hides the room from it.
    """

    def __init__(
        self, scene: Any, lamps: list[Lamp], surround: Surround, surface: Surface, height_mm: float
    ) -> None:
        self.height_mm = height_mm
        self._scene = scene
        self._lamps = lamps
        self._surround = surround
        self._surface = surface
        self.groups = len(lamps) + 1

    def without_shadows(self) -> Illuminator:
        """Give one for a surface before which nothing stands."""
        return Illuminator(None, self._lamps, self._surround, self._surface, self.height_mm)

    def lamps(
        self, st: Array, samples: int, seed: int, tally: Tally
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Give the lamps' irradiance / pi (n, groups) at points (n, 2), and who saw a shadow.

        The ambient group, last, is 0.
        """

        def shares(si: Any, points: Points) -> list[Any]:
            found, met = direct(self._lamps, self._scene, si, points)
            return [*found, mi.Float(0), dr.select(met, mi.Float(1), 0)]

        found = self._trace(shares, st, samples, seed, tally)
        return found[:, :-1], found[:, -1] > 0

    def open_room(self, st: Array, samples: int, seed: int, tally: Tally) -> Floats:
        """Give the surroundings' irradiance / pi (n, groups) if nothing stood in the way."""

        def shares(si: Any, points: Points) -> list[Any]:
            return self._surround.light(room_ray(si, points), mi.Mask(True))

        return self._trace(shares, st, samples, seed, tally)

    def hidden_room(self, st: Array, samples: int, seed: int, tally: Tally) -> Floats:
        """Give the part of `open_room` (n, groups) that needle and clutter keep off."""

        def shares(si: Any, points: Points) -> list[Any]:
            ray = room_ray(si, points)
            met = mi.Mask(False) if self._scene is None else self._scene.ray_test(ray)
            return [dr.select(met, light, 0) for light in self._surround.light(ray, met)]

        return self._trace(shares, st, samples, seed, tally)

    def _trace(
        self,
        shares: Callable[[Any, Points], list[Any]],
        st: Array,
        samples: int,
        seed: int,
        tally: Tally,
    ) -> Floats:
        rounds = -(-samples // TABLE_POINTS)
        if rounds > 1:
            each = -(-samples // rounds)
            parts = [self._trace(shares, st, each, seed32(seed, k), tally) for k in range(rounds)]
            mean: Floats = np.mean(parts, axis=0, dtype=np.float32)
            return mean
        places, normals = (
            found.astype(np.float32)
            for found in (self._surface.points(st), self._surface.normals(st))
        )
        values = []
        for part in batches(np.arange(len(st), dtype=np.uint32), samples):
            points, index = points_of(part, samples, seed)
            p, n = (
                [dr.gather(mi.Float, mi.Float(a[part, j].copy()), index) for j in range(3)]
                for a in (places, normals)
            )
            zero = dr.zeros(mi.Float, dr.width(index))
            found = shares(matt_point(mi.Point3f(p), mi.Normal3f(n)), points)
            values.append(means([value + zero for value in found], samples))
            tally.add(len(part) * samples)
        return np.concatenate(values) if values else np.zeros((0, self.groups + 1), np.float32)
