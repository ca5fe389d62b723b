"""The background's illumination, on a grid over its plane.

Light on a flat board changes slowly, so it is computed at grid points with many samples and
interpolated, once for both cameras, instead of anew with few samples in every pixel. The values at
the grid points are unbiased. Linear interpolation errs by at most 1/(4 n) of a shadow's depth, at
the corners of a penumbra that spans n grid steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.render.board import Board
from simtip.render.chunks import batches, means, stratified
from simtip.render.engine import dr, mi
from simtip.render.progress import Tally
from simtip.render.tube import Tube
from simtip.seeding import seed32

Floats = NDArray[np.float32]

COARSE_STEP_MM = 10.0
PILOT_STEP_MM = 4.0
PILOT_POINTS_MAX = 50_000
SHADOW_MARGIN_MM = 6.0
SAMPLES_PILOT = 64
ROOM_STEP_MM = 2.0
ROOM_POINTS_MAX = 50_000
SAMPLES_ROOM = 576
SAMPLES_OPEN = 16
SAMPLES_SHADOW = 256


@dataclass(frozen=True, eq=False)
class Grid:
    """Points `corner + step * (column, row)` in board coordinates, mm."""

    corner: Array
    step: float
    columns: int
    rows: int

    @classmethod
    def covering(cls, low: Array, high: Array, step: float) -> Grid:
        """Cover the box from `low` to `high` with at least four points each way."""
        columns, rows = np.maximum(np.ceil((high - low) / step).astype(int) + 1, 4)
        return cls(low, step, int(columns), int(rows))

    def points(self) -> Array:
        """Board coordinates (rows * columns, 2) of all points."""
        t, s = np.mgrid[: self.rows, : self.columns]
        return self.corner + self.step * np.stack([s.ravel(), t.ravel()], axis=1)

    def nearest(self, st: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Column and row (n,) of the point nearest to each of (n, 2) board coordinates."""
        column, row = np.rint((st - self.corner) / self.step).astype(np.intp).T
        return np.clip(column, 0, self.columns - 1), np.clip(row, 0, self.rows - 1)


@dataclass(frozen=True, eq=False)
class LightMap:
    """Irradiance / pi per unit lamp radiance on a grid: (rows, columns, lamps + 1) float32."""

    grid: Grid
    values: Floats


class Plane:
    """The background's plane in the renderer's own numbers."""

    def __init__(self, board: Board) -> None:
        self._axes = [
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in a]) for a in (board.x, board.y)
        ]
        self._normal = mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in board.normal])
        self._centre = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in board.centre])

    def meet(self, ray: Any) -> Any:
        """Where rays meet the plane, in the world."""
        return ray(dr.dot(self._centre - ray.o, self._normal) / dr.dot(ray.d, self._normal))

    def coordinates(self, point: Any) -> Any:
        """Board coordinates (s, t), mm, of points of the plane."""
        d = point - self._centre
        return mi.Point2f(dr.dot(d, self._axes[0]), dr.dot(d, self._axes[1]))


class Lookup(Plane):
    """Light maps as the renderer reads them: the fine one where it reaches, else the coarse."""

    def __init__(self, board: Board, fine: LightMap, coarse: LightMap) -> None:
        super().__init__(board)
        self.groups = fine.values.shape[-1]
        self._levels = [self._level(fine), self._level(coarse)]

    @staticmethod
    def _level(level: LightMap) -> tuple[Any, Any, Any, Any]:
        grid = level.grid
        texture = mi.Texture2f(
            mi.TensorXf(np.ascontiguousarray(level.values)),
            filter_mode=dr.FilterMode.Linear,
            wrap_mode=dr.WrapMode.Clamp,
        )
        corner = mi.Point2f([dr.opaque(mi.Float, float(v)) for v in grid.corner])
        extent = mi.Point2f(
            [dr.opaque(mi.Float, float(n * grid.step)) for n in (grid.columns, grid.rows)]
        )
        half_step = dr.opaque(mi.Float, grid.step / 2)
        return texture, corner, extent, half_step

    def at(self, point: Any, active: Any) -> list[Any]:
        """Irradiance / pi per lamp and ambient at points of the board."""
        st = self.coordinates(point)
        (fine, corner, extent, half), (coarse, corner_c, extent_c, half_c) = self._levels
        uv = (st - corner + half) / extent
        uv_c = (st - corner_c + half_c) / extent_c
        inside = dr.all((uv > 0) & (uv < 1))
        near = fine.eval(uv, active & inside)
        far = coarse.eval(uv_c, active & ~inside)
        return [dr.select(inside, a, b) for a, b in zip(near, far, strict=True)]


class Illuminator:
    """Sends light samples from points of the board to the lamps and the room."""

    def __init__(self, scene: Any, tubes: tuple[Tube, ...], board: Board) -> None:
        self._scene = scene
        self._tubes = tubes
        self._board = board
        self.groups = len(tubes) + 1
        self._normal = mi.Normal3f([dr.opaque(mi.Float, float(v)) for v in board.normal])

    def _shares(
        self, point: Any, sampler: Any, *, lamps: bool, room: bool
    ) -> tuple[list[Any], Any]:
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.p, si.n, si.t = point, self._normal, mi.Float(1)
        dark = dr.zeros(mi.Float, dr.width(point))
        shares, blocked = [] if lamps else [dark] * len(self._tubes), dark > 0
        for tube in self._tubes if lamps else ():
            sample = tube.sample(point, sampler.next_2d())
            cosine = dr.dot(self._normal, sample.direction)
            lit = (cosine > 0) & (sample.weight > 0)
            shadow = lit & self._scene.ray_test(si.spawn_ray_to(sample.point), lit)
            blocked |= shadow
            shares.append(dr.select(lit & ~shadow, cosine * sample.weight * dr.inv_pi, 0))
        if not room:
            return [*shares, dark], blocked
        towards = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        ray = si.spawn_ray(mi.Frame3f(self._normal).to_world(towards))
        shares.append(dr.select(self._scene.ray_test(ray), mi.Float(0), 1))
        return shares, blocked

    def trace(
        self,
        st: Array,
        samples: int,
        seed: int,
        tally: Tally,
        *,
        lamps: bool = True,
        room: bool = True,
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Estimate irradiance / pi at board points (n, 2).

        Gives (n, lamps + 1), 0 for what is left out; and (n,) whether a lamp met a shadow.
        """
        world = self._board.centre + st @ np.stack([self._board.x, self._board.y])
        values = [np.zeros((0, self.groups), np.float32)]
        shadows = [np.zeros(0, np.bool_)]
        for k, part in enumerate(batches(world.astype(np.float32), samples)):
            sampler, index = stratified(len(part), samples, seed32(seed, k))
            point = mi.Point3f(
                [dr.gather(mi.Float, mi.Float(part[:, j].copy()), index) for j in range(3)]
            )
            shares, blocked = self._shares(point, sampler, lamps=lamps, room=room)
            found = means([*shares, dr.select(blocked, mi.Float(1), 0)], samples)
            values.append(found[:, :-1])
            shadows.append(found[:, -1] > 0)
            tally.add(len(part) * samples)
        return np.concatenate(values), np.concatenate(shadows)


def limited_step(low: Array, high: Array, step: float, points: int) -> float:
    """Widen a step so that a box takes no more than about so many points."""
    return max(step, float(np.sqrt(np.prod(high - low) / points)))


def _shadow_pilot(
    light: Illuminator, low: Array, high: Array, seed: int
) -> tuple[Grid, NDArray[np.bool_]]:
    """Find roughly where the needle's shadows fall; only the effort depends on it, no value."""
    grid = Grid.covering(low, high, limited_step(low, high, PILOT_STEP_MM, PILOT_POINTS_MAX))
    _, met = light.trace(grid.points(), SAMPLES_PILOT, seed, Tally(None), room=False)
    reach = 2 * int(np.ceil(SHADOW_MARGIN_MM / grid.step)) + 1
    mask = met.reshape(grid.rows, grid.columns).astype(np.uint8)
    return grid, cv2.dilate(mask, np.ones((reach, reach), np.uint8)) > 0


def _room_light(
    light: Illuminator, grid: Grid, low: Array, high: Array, seed: int, tally: Tally
) -> Floats:
    """Give the room's light at the points of a grid (rows, columns).

    What the needle hides of the room changes over as many millimetres as the needle is off the
    board, so that a wider grid serves, with more samples: few of them are hidden.
    """
    step = max(grid.step, limited_step(low, high, ROOM_STEP_MM, ROOM_POINTS_MAX))
    wide = Grid.covering(low, high, step)
    points = wide.points()
    tally.plan(len(points) * SAMPLES_ROOM)
    found, _ = light.trace(points, SAMPLES_ROOM, seed, tally, lamps=False)
    where = ((grid.points() - wide.corner) / wide.step).astype(np.float32)
    u, v = where.reshape(grid.rows, grid.columns, 2).transpose(2, 0, 1)
    values = np.ascontiguousarray(found[:, -1].reshape(wide.rows, wide.columns))
    room = cv2.remap(values, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(room, np.float32)


def light_map(
    light: Illuminator, low: Array, high: Array, step: float, seed: int, tally: Tally
) -> LightMap:
    """Compute the map over a box of the board, with most samples where shadows fall."""
    pilot, shadowed = _shadow_pilot(light, low, high, seed32(seed, "pilot"))
    grid = Grid.covering(low, high, step)
    points = grid.points()
    column, row = pilot.nearest(points)
    dark = shadowed[row, column]
    parts = [("open", ~dark, SAMPLES_OPEN), ("shadow", dark, SAMPLES_SHADOW)]
    tally.plan(sum(int(chosen.sum()) * samples for _, chosen, samples in parts))
    values = np.zeros((len(points), light.groups), np.float32)
    for name, chosen, samples in parts:
        values[chosen], _ = light.trace(
            points[chosen], samples, seed32(seed, name), tally, room=False
        )
    layers: Floats = values.reshape(grid.rows, grid.columns, -1)
    layers[..., -1] = _room_light(light, grid, low, high, seed32(seed, "room"), tally)
    return LightMap(grid, layers)
