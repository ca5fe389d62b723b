"""The background as rays see it: its light, its paper, what is printed on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.clutter import BoardTexture
from simtip.geometry import Array
from simtip.render.board import Board
from simtip.render.chunks import aligned
from simtip.render.engine import dr, mi
from simtip.render.lightmap import LightMap

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set

LEAST_HEIGHT = 0.05
"""Sine of the height above the board from which wrinkles take a lamp's light to come, at least: the
middle of a lamp that reaches behind the board would make them endlessly steep."""


class Plane:
    """The background's plane in the renderer's own numbers."""

    def __init__(self, board: Board) -> None:
        self._axes = [
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in a]) for a in (board.x, board.y)
        ]
        self._normal = mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in board.normal])
        self._centre = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in board.centre])

    def meet(self, ray: Vec) -> Vec:
        """Where rays meet the plane, in the world."""
        return ray(dr.dot(self._centre - ray.o, self._normal) / dr.dot(ray.d, self._normal))

    def coordinates(self, point: Vec) -> Vec:
        """Board coordinates (s, t), mm, of points of the plane."""
        d = point - self._centre
        return mi.Point2f(dr.dot(d, self._axes[0]), dr.dot(d, self._axes[1]))


class Raster:
    """Values on a grid of the board, read with linear interpolation.

    Parameters
    ----------
    values
        (rows, columns, n).
    corner, step
        Board coordinates (2,) of the first grid point, and the distance of the next, mm.
    """

    def __init__(self, values: NDArray[np.float32], corner: Array, step: float) -> None:
        rows, columns = values.shape[:2]
        self._texture = mi.Texture2f(
            mi.TensorXf(aligned(values)),
            filter_mode=dr.FilterMode.Linear,
            wrap_mode=dr.WrapMode.Clamp,
        )
        self._corner = mi.Point2f([dr.opaque(mi.Float, float(v - step / 2)) for v in corner])
        self._extent = mi.Point2f([dr.opaque(mi.Float, float(n * step)) for n in (columns, rows)])

    def place(self, st: Vec) -> tuple[Vec, Vec]:
        """Give texture coordinates of board coordinates, and whether they lie on the grid."""
        uv = (st - self._corner) / self._extent
        return uv, dr.all((uv > 0) & (uv < 1))

    def at(self, uv: Vec, active: Vec) -> list[Vec]:
        """Read the values."""
        values: list[Vec] = list(self._texture.eval(uv, active))
        return values


@dataclass(frozen=True)
class _Paper:
    """What is on the board in view."""

    look: Raster
    """Factor on the albedo, and coverage by prints."""
    slope: Raster | None
    lamps: list[Vec]
    """The lamps' middles, from where wrinkles take their light to come."""


class Backdrop(Plane):
    """What rays bring back from the background, per light group of unit radiance.

    Its light comes from two maps, the fine one where it reaches, else the coarse. Wrinkles tilt
    the paper: each lamp's light changes by the cosine to its middle, the ambient's not.
    """

    def __init__(
        self,
        board: Board,
        albedo: Array,
        light: tuple[LightMap, LightMap],
        texture: BoardTexture | None = None,
        lamp_places: tuple[Array, ...] = (),
    ) -> None:
        super().__init__(board)
        fine, coarse = light
        self.groups = fine.values.shape[-1]
        self.board = board
        self.albedo = albedo
        self.texture = texture
        self.light_maps = light
        self._albedo = mi.Color3f([dr.opaque(mi.Float, float(v)) for v in albedo])
        self._fine = Raster(fine.values, fine.grid.corner, fine.grid.step)
        self._coarse = Raster(coarse.values, coarse.grid.corner, coarse.grid.step)
        self._paper = None if texture is None else _paper(texture, lamp_places)

    def light(self, st: Vec, active: Vec) -> list[Vec]:
        """Give irradiance / pi per group at board coordinates, the board taken as flat."""
        uv, inside = self._fine.place(st)
        uv_coarse, _ = self._coarse.place(st)
        near = self._fine.at(uv, active & inside)
        far = self._coarse.at(uv_coarse, active & ~inside)
        return [dr.select(inside, a, b) for a, b in zip(near, far, strict=True)]

    def gray(self, point: Vec, active: Vec) -> tuple[list[Vec], Vec]:
        """Give radiance over mean albedo per group, and how much prints cover."""
        st = self.coordinates(point)
        light = self.light(st, active)
        if self._paper is None:
            return light, mi.Float(0)
        uv, inside = self._paper.look.place(st)
        factor, printed = self._paper.look.at(uv, active & inside)
        factor = dr.select(inside, factor, 1)
        shades = [mi.Float(1) for _ in light]
        if self._paper.slope is not None:
            uv, near = self._paper.slope.place(st)
            ds, dt = self._paper.slope.at(uv, active & near)
            upright = dr.rsqrt(1 + ds * ds + dt * dt)
            tilts = [
                dr.maximum(1 - ds * along - dt * across, 0) * upright
                for along, across in (self._tangents(point, lamp) for lamp in self._paper.lamps)
            ]
            shades = [*(dr.select(near, tilt, 1) for tilt in tilts), mi.Float(1)]
        lit = [part * factor * shade for part, shade in zip(light, shades, strict=True)]
        return lit, dr.select(inside, printed, 0)

    def _tangents(self, point: Vec, lamp: Vec) -> tuple[Vec, Vec]:
        """Give how far the way to a lamp leads along s and along t, over how far off the board."""
        d = lamp - point
        height = dr.maximum(dr.dot(d, self._normal), LEAST_HEIGHT * dr.norm(d))
        return dr.dot(d, self._axes[0]) / height, dr.dot(d, self._axes[1]) / height

    def radiance(self, point: Vec, active: Vec) -> tuple[list[Vec], Vec]:
        """Give radiance (r, g, b) per group at points of the board, and how much prints cover."""
        gray, printed = self.gray(point, active)
        return [self._albedo * part for part in gray], printed


def _paper(texture: BoardTexture, lamp_places: tuple[Array, ...]) -> _Paper:
    look = Raster(
        np.stack([texture.albedo, texture.clutter], axis=-1), texture.corner_mm, texture.step_mm
    )
    slope = None
    if texture.slope is not None:
        slope = Raster(texture.slope, texture.slope_corner_mm, texture.slope_step_mm)
    places = [mi.Point3f([dr.opaque(mi.Float, float(v)) for v in place]) for place in lamp_places]
    return _Paper(look, slope, places)
