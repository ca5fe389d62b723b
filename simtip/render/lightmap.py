"""The background's illumination, on a grid over its plane.

Light on a flat board changes slowly, so it is computed at grid points with many samples and
interpolated, once for both cameras, instead of anew with few samples in every pixel. The values at
the grid points are unbiased. Linear interpolation errs by at most 1/(4 n) of a shadow's depth, at
the corners of a penumbra that spans n grid steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.render.illuminator import Illuminator
from simtip.render.progress import Tally
from simtip.render.sobol_table import TABLE_POINTS
from simtip.seeding import seed32

Floats = NDArray[np.float32]

COARSE_STEP_MM = 10.0
PILOT_STEP_MM = 4.0
PILOT_POINTS_MAX = 50_000
SHADOW_MARGIN_MM = 6.0
SAMPLES_PILOT = 64
ROOM_STEPS_MM = (2.0, 40.0)
ROOM_POINTS_MAX = 50_000
ROOM_SAMPLES = (512, TABLE_POINTS)
HEIGHT_STEPS = 4.0
"""What something hides of the room changes over as many millimetres as it is off the board; so many
grid steps there leave an error of under 1 % of that little."""
SAMPLES_OPEN = 16
SAMPLES_SHADOW = 256
NOISE_WINDOW = 9
"""Grid points, each way, over which their noise is averaged."""
LAMP_SHARE, ROOM_SHARE = 0.8, 0.5
"""Of the noise that is allowed."""
CONVERGENCE = 1.5
"""The variance falls with this power of the samples, where lamps are seen in part."""
MOST_EFFORT = 16

Trace = Callable[[Array, int, int, Tally], Floats]
"""From places (n, 2), samples, a seed and a tally to light (n, groups)."""

Lack = Callable[[Floats, Floats], Floats]
"""From light (rows, columns, groups) and the standard deviation of part of it to how many times
that is what may be left, (rows, columns)."""


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


def read_at(layer: Floats, u: Floats, v: Floats) -> Floats:
    """Read a grid (rows, columns) at places (n,), in grid steps, linearly between its points."""
    found = [
        cv2.remap(
            np.ascontiguousarray(layer), a[None].astype(np.float32), b[None].astype(np.float32),
            cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE,
        )[0]
        for a, b in zip(_pieces(u), _pieces(v), strict=True)
    ]  # fmt: skip
    return np.concatenate(found) if found else np.zeros(0, np.float32)


def _pieces(values: Floats) -> list[Floats]:
    """Cut into rows no longer than cv2.remap takes."""
    return [values[k : k + 32_000] for k in range(0, len(values), 32_000)]


def kept(place: Floats) -> Floats:
    """Give what linear interpolation between two points leaves of their variance."""
    part = place - np.floor(place)
    left: Floats = part**2 + (1 - part) ** 2
    return left


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
        Their Monte-Carlo standard deviation, likewise, from two independent halves.
    """

    grid: Grid
    values: Floats
    sd: Floats
    shared_sd: Floats

    def sd_at(self, st: Floats, group: int) -> Floats:
        """Give the error (n,) of what linear interpolation finds at board coordinates (n, 2)."""
        u, v = ((st[:, k] - self.grid.corner[k]) / self.grid.step for k in (0, 1))
        own = read_at(self.sd[..., group], u, v) * np.sqrt(kept(u) * kept(v))
        error: Floats = np.hypot(own, read_at(self.shared_sd[..., group], u, v))
        return error


def limited_step(low: Array, high: Array, step: float, points: int) -> float:
    """Widen a step so that a box takes no more than about so many points."""
    return max(step, float(np.sqrt(np.prod(high - low) / points)))


def with_noise(
    trace: Trace, grid: Grid, samples: NDArray[np.int64], seed: int, tally: Tally
) -> tuple[Floats, Floats]:
    """Trace all points of a grid, every fourth twice, each with so many samples (n,).

    Gives the values (rows, columns, groups) and their standard deviation, which is from the
    differences of what was traced twice, averaged over a window.
    """
    points = grid.points()
    again = np.zeros((grid.rows, grid.columns), np.bool_)
    again[::2, ::2] = True
    some = again.reshape(-1)
    tally.plan(int(samples.sum() + samples[some].sum()))

    def traced(chosen: NDArray[np.bool_], seed: int) -> Floats:
        st, each = points[chosen], samples[chosen]
        found = [
            (each == n, trace(st[each == n], int(n), seed32(seed, int(n)), tally))
            for n in np.unique(each)
        ]
        values = np.empty((len(st), found[0][1].shape[1]), np.float32)
        for here, part in found:
            values[here] = part
        return values

    values = traced(np.ones_like(some), seed).reshape(grid.rows, grid.columns, -1)
    other = traced(some, seed32(seed, "again"))
    return values, smoothed_sd(values[again] - other, again)


def smoothed_sd(difference: Floats, where: NDArray[np.bool_]) -> Floats:
    """Give the standard deviation (rows, columns, groups) of values, some of them found twice.

    `difference` (n, groups) is that of the two, at the points `where` (rows, columns).
    """
    squares = np.zeros((*where.shape, difference.shape[-1] + 1), np.float32)
    squares[where, :-1] = difference**2 / 2
    squares[where, -1] = 1
    if squares.shape[-1] == 1:
        return squares[..., :-1]
    window = (NOISE_WINDOW, NOISE_WINDOW)
    layers = [
        cv2.blur(np.ascontiguousarray(layer), window, borderType=cv2.BORDER_REFLECT)
        for layer in np.moveaxis(squares, -1, 0)
    ]
    sd: Floats = np.sqrt(np.maximum(np.stack(layers[:-1], axis=-1), 0) / layers[-1][..., None])
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
    lack: Lack | None = None,
) -> LightMap:
    """Compute the map over a box of the board, with most samples where shadows fall.

    Parameters
    ----------
    light
        Where the light comes from.
    low, high
        (2,) the box's corners, board coordinates, mm.
    step
        Of the grid, mm.
    seed
        Of the samples.
    tally
        Told what is planned and done.
    room_effort
        Scales the samples of what hides the room: a map seen only in mirrors, which average over
        it, needs few.
    lack
        Says how much too noisy the map is, so that it is computed again with more samples.
    """
    pilot, shadowed = _shadow_pilot(light, low, high, step, seed32(seed, "pilot"))
    grid = Grid.covering(low, high, step)
    column, row = pilot.nearest(grid.points())
    samples = np.where(shadowed[row, column], SAMPLES_SHADOW, SAMPLES_OPEN)

    def lamps(samples: NDArray[np.int64]) -> tuple[Floats, Floats]:
        def trace(st: Array, each: int, seed: int, tally: Tally) -> Floats:
            return light.lamps(st, each, seed, tally)[0]

        return with_noise(trace, grid, samples, seed, tally)

    def room(effort: float) -> tuple[Floats, Floats]:
        return _room_light(light, grid, low, high, effort, seed32(seed, "room"), tally)

    (direct_light, direct_sd), (round_light, round_sd) = lamps(samples), room(room_effort)
    if lack is not None:
        total = direct_light + round_light
        efforts = effort_for(lack(total, direct_sd).reshape(-1) / LAMP_SHARE)
        if efforts.max() > 1:
            direct_light, direct_sd = lamps(samples * efforts)
        effort = int(np.median(effort_for(lack(total, round_sd) / ROOM_SHARE)))
        if effort > 1:
            round_light, round_sd = room(effort * room_effort)
    return LightMap(grid, direct_light + round_light, direct_sd, round_sd)


def effort_for(lack: Floats) -> NDArray[np.int64]:
    """Give by how much samples have to grow where the noise is so many times what it may be."""
    need = np.clip(lack ** (2 / CONVERGENCE), 1, MOST_EFFORT)
    return np.asarray(2 ** np.ceil(np.log2(need)), np.int64)


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
    samples = max(1, int(effort * min(most, fewest * (step / finest) ** 2)))
    hidden, hidden_sd = _spread(
        light.hidden_room, samples, step, grid, low, high, seed32(seed, "hid"), tally
    )
    whole, whole_sd = _spread(
        light.open_room,
        most * max(1, int(effort)),
        widest,
        grid,
        low,
        high,
        seed32(seed, "all"),
        tally,
    )
    return whole - hidden, np.hypot(whole_sd, hidden_sd)


def _spread(
    trace: Trace,
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
    each = np.full(wide.rows * wide.columns, samples, np.int64)
    found, sd = with_noise(trace, wide, each, seed, tally)
    u, v = ((grid.points() - wide.corner) / wide.step).T.astype(np.float32)
    shape = grid.rows, grid.columns

    def at_grid(values: Floats) -> Floats:
        layers = [read_at(layer, u, v).reshape(shape) for layer in np.moveaxis(values, -1, 0)]
        return np.stack(layers, axis=-1)

    return at_grid(found), at_grid(sd) * np.sqrt(kept(u) * kept(v)).reshape(*shape, 1)
