"""What rays see that leave the scene: an even room, or walls lit by the lamps."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from typing_extensions import override

from simtip.geometry import Array
from simtip.render.chunks import aligned, batches, means
from simtip.render.engine import dr, mi
from simtip.render.illumination import direct, matt_point
from simtip.render.lamps import Lamp
from simtip.render.sobol import points_of
from simtip.spec import RoomSpec

WALL_NODES = 128
"""Grid points along each side of a wall: 2 % of the brightest spot with tubes 0.2 m off a ceiling
4 m wide (24 points: 18 %)."""
WALL_SAMPLES = 128

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


class Surround(Protocol):
    """The surroundings, per light group."""

    def light(self, ray: Vec, active: Vec) -> list[Vec]:
        """Give what each group, the ambient last, sends against rays that leave the scene."""


class EvenRoom(Surround):
    """The ambient light, equal from everywhere, and nothing else."""

    def __init__(self, lamps: int) -> None:
        self._lamps = lamps

    @override
    def light(self, ray: Vec, active: Vec) -> list[Vec]:
        """Give unit radiance to the ambient group."""
        return [*(mi.Float(0) for _ in range(self._lamps)), mi.Float(1)]


class WalledRoom:
    """A box of matt walls, each lamp's light on them worked out on a grid; and the ambient."""

    def __init__(self, room: RoomSpec, lamps: list[Lamp], seed: int) -> None:
        self._lamps = len(lamps)
        low, high = np.array(room.low_mm), np.array(room.high_mm)
        self._low, self._high = (
            mi.Point3f([dr.opaque(mi.Float, float(v)) for v in corner]) for corner in (low, high)
        )
        points, normals = _nodes(low, high)
        albedo = np.repeat(
            [room.walls, room.walls, room.ceiling, room.floor, room.walls, room.walls],
            WALL_NODES**2,
        )
        light = _wall_light(lamps, points, normals, seed) * albedo[:, None].astype(np.float32)
        self._texture = mi.Texture2f(
            mi.TensorXf(aligned(light.reshape(6 * WALL_NODES, WALL_NODES, -1))),
            filter_mode=dr.FilterMode.Linear,
            wrap_mode=dr.WrapMode.Clamp,
        )

    def light(self, ray: Vec, active: Vec) -> list[Vec]:
        """Give each lamp's light off the wall that the ray meets, and the ambient's."""
        ends = [
            dr.select(d > 0, high, low)
            for d, low, high in zip(ray.d, self._low, self._high, strict=True)
        ]
        # A ray along a wall never meets it.
        t = [
            dr.select(d == 0, dr.inf, (end - o) / d)
            for end, o, d in zip(ends, ray.o, ray.d, strict=True)
        ]
        nearest = dr.minimum(dr.minimum(t[0], t[1]), t[2])
        place = (ray(nearest) - self._low) / (self._high - self._low)
        across_x, across_y = t[0] == nearest, t[1] == nearest
        axis = dr.select(across_x, mi.Float(0), dr.select(across_y, mi.Float(1), mi.Float(2)))
        d = dr.select(across_x, ray.d.x, dr.select(across_y, ray.d.y, ray.d.z))
        wall = 2 * axis + dr.select(d > 0, mi.Float(1), 0)
        u = dr.select(across_x, place.y, place.x)
        v = dr.select(across_x | across_y, place.z, place.y)
        n = WALL_NODES
        column = (0.5 + dr.clip(u, 0, 1) * (n - 1)) / n
        row = (0.5 + dr.clip(v, 0, 1) * (n - 1) + wall * n) / (6 * n)
        return [*self._texture.eval(mi.Point2f(column, row), active), mi.Float(1)]


def _nodes(low: Array, high: Array) -> tuple[Array, Array]:
    """Give grid points on all walls, (6 n n, 3), and the walls' inward normals.

    Walls go x low, x high, y low, .., z high; on each, rows run along the later of the other axes.
    """
    steps = np.linspace(0, 1, WALL_NODES)
    points, normals = [], []
    for axis in range(3):
        u, v = (k for k in range(3) if k != axis)
        for side in (0.0, 1.0):
            place = np.full((WALL_NODES, WALL_NODES, 3), side)
            place[..., u], place[..., v] = np.meshgrid(steps, steps)
            points.append(low + place.reshape(-1, 3) * (high - low))
            normal = np.zeros(3)
            normal[axis] = 1 - 2 * side
            normals.append(np.tile(normal, (WALL_NODES**2, 1)))
    return np.concatenate(points), np.concatenate(normals)


def _wall_light(lamps: list[Lamp], points: Array, normals: Array, seed: int) -> Any:
    """Give irradiance / pi (n, lamps) at points of the walls; nothing throws shadows there."""
    places = np.arange(len(points), dtype=np.uint32)
    found = []
    for part in batches(places, WALL_SAMPLES):
        sampler, index = points_of(part, WALL_SAMPLES, seed)
        p, n = (
            [dr.gather(mi.Float, mi.Float(a[part, k].astype(np.float32)), index) for k in range(3)]
            for a in (points, normals)
        )
        si = matt_point(mi.Point3f(p), mi.Normal3f(n))
        shares, _ = direct(lamps, None, si, sampler)
        found.append(means(shares, WALL_SAMPLES))
    return np.concatenate(found)
