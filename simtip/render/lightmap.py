"""The background's illumination, on a grid over its plane.

Light on a flat board changes slowly, so it is computed at grid points with many samples and
interpolated, once for both cameras, instead of anew with few samples in every pixel. The values at
the grid points are unbiased. Linear interpolation errs by at most 1/(4 n) of a shadow's depth, at
the corners of a penumbra that spans n grid steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.render.board import Board
from simtip.render.chunks import batches, means
from simtip.render.engine import dr, mi
from simtip.render.illumination import direct, matt_point, room_ray
from simtip.render.lamps import Lamp
from simtip.render.progress import Tally
from simtip.render.sobol import Points, points_of
from simtip.render.surround import Surround
from simtip.seeding import seed32

Floats = NDArray[np.float32]

COARSE_STEP_MM = 10.0
PILOT_STEP_MM = 4.0
PILOT_POINTS_MAX = 50_000
SHADOW_MARGIN_MM = 6.0
SAMPLES_PILOT = 64
ROOM_STEPS_MM = (2.0, 40.0)
ROOM_POINTS_MAX = 50_000
ROOM_SAMPLES = (512, 8192)
HEIGHT_STEPS = 4.0
"""What something hides of the room changes over as many millimetres as it is off the board; so many
grid steps there leave an error of under 1 % of that little."""
SAMPLES_OPEN = 16
SAMPLES_SHADOW = 256
NOISE_WINDOW = 9
"""Grid points, each way, over which the scatter of the values is averaged."""


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
    """Irradiance / pi per unit lamp radiance on a grid.

    Attributes
    ----------
    grid
        Where.
    values
        (rows, columns, groups) float32.
    sd
        Their Monte-Carlo standard deviation, likewise, from their scatter about their neighbours.
    """

    grid: Grid
    values: Floats
    sd: Floats


class Illuminator:
    """Sends light samples from points of the board to the lamps and the room.

    `height_mm` is how far off the board the nearest thing is that hides the room from it.
    """

    def __init__(
        self, scene: Any, lamps: list[Lamp], surround: Surround, board: Board, height_mm: float
    ) -> None:
        self.height_mm = height_mm
        self._scene = scene
        self._lamps = lamps
        self._surround = surround
        self._board = board
        self.groups = len(lamps) + 1
        self._normal = mi.Normal3f([dr.opaque(mi.Float, float(v)) for v in board.normal])

    def without_shadows(self) -> Illuminator:
        """Give one for a board before which nothing stands."""
        return Illuminator(None, self._lamps, self._surround, self._board, self.height_mm)

    def lamps(
        self, st: Array, samples: int, seed: int, tally: Tally
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Give the lamps' irradiance / pi (n, groups) at board points (n, 2), and who saw a shadow.

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
        world = self._board.points(st).astype(np.float32)
        values = []
        for part in batches(np.arange(len(st), dtype=np.uint32), samples):
            points, index = points_of(part, samples, seed)
            place = world[part]
            p = [dr.gather(mi.Float, mi.Float(place[:, j].copy()), index) for j in range(3)]
            zero = dr.zeros(mi.Float, dr.width(index))
            found = shares(matt_point(mi.Point3f(p), self._normal), points)
            values.append(means([value + zero for value in found], samples))
            tally.add(len(part) * samples)
        return np.concatenate(values) if values else np.zeros((0, self.groups + 1), np.float32)


def limited_step(low: Array, high: Array, step: float, points: int) -> float:
    """Widen a step so that a box takes no more than about so many points."""
    return max(step, float(np.sqrt(np.prod(high - low) / points)))


def scatter(values: Floats) -> Floats:
    """Give the standard deviation of the noise in (rows, columns, n) values, where they are smooth.

    From second differences both ways, which planes and cylinders leave at zero, averaged over a
    window: J. Immerkaer, "Fast noise variance estimation", CVIU 64 (1996). Whatever else bends
    both ways counts as noise.
    """
    kernel = np.array([1.0, -2.0, 1.0], np.float32)
    if not values.shape[-1]:
        return values
    bent = cv2.sepFilter2D(values, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REFLECT_101)
    window = (NOISE_WINDOW, NOISE_WINDOW)
    squares = cv2.blur(bent * bent, window, borderType=cv2.BORDER_REFLECT)
    sd: Floats = np.sqrt(np.maximum(squares.reshape(values.shape), 0) / 36)
    return sd


def light_map(
    light: Illuminator,
    low: Array,
    high: Array,
    step: float,
    seed: int,
    tally: Tally,
    *,
    room_effort: float = 1.0,
) -> LightMap:
    """Compute the map over a box of the board, with most samples where shadows fall.

    `room_effort` scales the samples of what hides the room: a map seen only in mirrors, which
    average over it, needs few.
    """
    pilot, shadowed = _shadow_pilot(light, low, high, step, seed32(seed, "pilot"))
    grid = Grid.covering(low, high, step)
    points = grid.points()
    column, row = pilot.nearest(points)
    dark = shadowed[row, column]
    parts = [("open", ~dark, SAMPLES_OPEN), ("shadow", dark, SAMPLES_SHADOW)]
    tally.plan(sum(int(chosen.sum()) * samples for _, chosen, samples in parts))
    values = np.zeros((len(points), light.groups), np.float32)
    for name, chosen, samples in parts:
        if chosen.any():
            values[chosen], _ = light.lamps(points[chosen], samples, seed32(seed, name), tally)
    layers: Floats = values.reshape(grid.rows, grid.columns, -1)
    sd = scatter(layers)
    room, room_sd = _room_light(light, grid, low, high, room_effort, seed32(seed, "room"), tally)
    return LightMap(grid, layers + room, np.hypot(sd, room_sd))


def _shadow_pilot(
    light: Illuminator, low: Array, high: Array, step: float, seed: int
) -> tuple[Grid, NDArray[np.bool_]]:
    """Find roughly where shadows fall; only the effort depends on it, no value."""
    step = limited_step(low, high, max(step, PILOT_STEP_MM), PILOT_POINTS_MAX)
    grid = Grid.covering(low, high, step)
    _, met = light.lamps(grid.points(), SAMPLES_PILOT, seed, Tally(None))
    reach = 2 * int(np.ceil(SHADOW_MARGIN_MM / grid.step)) + 1
    mask = met.reshape(grid.rows, grid.columns).astype(np.uint8)
    return grid, cv2.dilate(mask, np.ones((reach, reach), np.uint8)) > 0


def _room_light(
    light: Illuminator,
    grid: Grid,
    low: Array,
    high: Array,
    effort: float,
    seed: int,
    tally: Tally,
) -> tuple[Floats, Floats]:
    """Give the surroundings' light at the points of a grid (rows, columns, groups), and its noise.

    All of it, as if nothing stood before the board, is smooth and takes few points with many
    samples; so does what hangs high above the board hide of it.
    """
    finest, widest = ROOM_STEPS_MM
    step = float(np.clip(light.height_mm / HEIGHT_STEPS, finest, widest))
    fewest, most = ROOM_SAMPLES
    samples = int(effort * min(most, fewest * (step / finest) ** 2))
    hidden, hidden_sd = _spread(
        light.hidden_room, samples, step, grid, low, high, seed32(seed, "hid"), tally
    )
    whole, whole_sd = _spread(
        light.open_room, most, widest, grid, low, high, seed32(seed, "all"), tally
    )
    return whole - hidden, np.hypot(whole_sd, hidden_sd)


def _spread(
    trace: Callable[[Array, int, int, Tally], Floats],
    samples: int,
    step: float,
    grid: Grid,
    low: Array,
    high: Array,
    seed: int,
    tally: Tally,
) -> tuple[Floats, Floats]:
    """Trace on a wider grid, and interpolate its values and their noise at the points of `grid`."""
    step = max(grid.step, limited_step(low, high, step, ROOM_POINTS_MAX))
    wide = Grid.covering(low, high, step)
    points = wide.points()
    tally.plan(len(points) * samples)
    found = trace(points, samples, seed, tally).reshape(wide.rows, wide.columns, -1)
    where = ((grid.points() - wide.corner) / wide.step).astype(np.float32)
    u, v = where.reshape(grid.rows, grid.columns, 2).transpose(2, 0, 1)

    def at_grid(values: Floats) -> Floats:
        layers = [
            cv2.remap(layer, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            for layer in np.moveaxis(values, -1, 0)
        ]
        return np.stack(layers, axis=-1).astype(np.float32)

    return at_grid(found), at_grid(scatter(found))
