"""A calibration board before the cameras: matt paper, printed, lit by lamps and room.

Its light changes slowly and nothing stands before it, so it is mapped once (`lightmap`), bent as
the plate is; the print is a raster (`ink`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from simtip.camera import Camera
from simtip.geometry import Array, Pose
from simtip.plate import Plate
from simtip.render.backdrop import Raster
from simtip.render.chunks import aligned, batches
from simtip.render.engine import dr, mi
from simtip.render.ink import InkRaster, ink_raster
from simtip.render.lamps import pointer
from simtip.render.mesh import mesh_of
from simtip.render.subject import Mask, Pixels, Subject
from simtip.spec.boards import PlateSpec
from simtip.target import Target

if TYPE_CHECKING:
    from simtip.render.backdrop import Backdrop
    from simtip.render.eye import Eye
    from simtip.render.lighting import Lighting
    from simtip.render.sobol import Points
    from simtip.render.world import World

LIGHT_STEP_MM = 4.0
CLEAR_STEP_MM = 0.1
PIXEL_REACH = 0.6
"""Of the sides of a pixel from its centre: a half, and some for perspective."""
MOST_SLANT = 4.0
"""Tangent of the angle to its normal at which a board is seen, far over what poses allow."""
SAME = 1e-3
"""Ink that differs by less is even."""

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


class BoardSubject(Subject):
    """A calibration board.

    Parameters
    ----------
    plate
        Its geometry.
    T_wt
        From its frame to the world, mm.
    look
        Its albedo and print.
    """

    def __init__(self, plate: Plate, T_wt: Pose, look: PlateSpec) -> None:
        self._plate, self._T_wt, self._look = plate, T_wt, look
        inverse = T_wt.inverse()
        self._axes = [
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in row]) for row in inverse.R[:2]
        ]
        self._normal = mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in inverse.R[2]])
        self._origin = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in T_wt.t])
        ink = _ink(plate.target, look.edge_blur_mm)
        self._ink = Raster(ink.values[..., None], ink.corner_mm, ink.step_mm)
        self._print_scale = mi.Point2f([dr.opaque(mi.Float, float(v)) for v in plate.print_scale])
        self._bare, self._inked = (
            mi.Color3f([dr.opaque(mi.Float, float(v)) for v in albedo])
            for albedo in (look.albedo, look.ink_albedo)
        )
        self._light: Raster | None = None
        self._parts: list[Any] = []

    @override
    def vertices(self) -> Array:
        """Give points (n, 3) of its rim and back, world, mm."""
        return self._T_wt.apply(self._plate.body()[0])

    @override
    def footprint(self, T_cw: Pose, camera: Camera, margin_px: float) -> Mask:
        """Mark every pixel (H, W) that it may touch, and all within a margin of those."""
        plate, T_ct = self._plate, T_cw @ self._T_wt
        canvas = np.zeros((camera.height, camera.width), np.uint8)
        rim = plate.outline()
        through = np.array([0, 0, plate.thickness_mm])
        hulls = [rim + through, rim]
        for hull in hulls:
            pixels = np.clip(camera.project(T_ct.apply(hull)), -16_000, 16_000)
            cv2.fillPoly(canvas, [np.rint(pixels).astype(np.int32)], 1)
        # The sides lie between the two; a bent face may bulge by the bow.
        reach = margin_px + 2 + _thickness_px(plate, T_ct, camera)
        size = 2 * int(np.ceil(reach)) + 1
        return cv2.dilate(canvas, np.ones((size, size), np.uint8)) > 0

    @override
    def shapes(self) -> dict[str, Any]:
        """Describe its printed side, and the rest of it."""
        front, body = self._plate.front(), self._plate.body()
        matt = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(self._look.albedo)}}
        return {
            name: mesh_of(name, self._T_wt.apply(vertices), faces, {"bsdf": matt})
            for name, (vertices, faces) in (("board", front), ("board_body", body))
        }

    @override
    def bind(self, shapes: dict[str, Any]) -> None:
        """Take hold of its shapes."""
        self._parts = [pointer(shapes[name]) for name in ("board", "board_body")]

    def points(self, st: Array) -> Array:
        """World points (n, 3) of its own coordinates (n, 2), mm."""
        return self._T_wt.apply(self._plate.surface(st))

    def normals(self, st: Array) -> Array:
        """World normals (n, 3), likewise."""
        return self._T_wt.rotate(self._plate.normals(st))

    @override
    def light(self, lighting: Lighting) -> None:
        """Map the light on its printed side."""
        found = lighting.on(
            self, self._plate.low, self._plate.high, LIGHT_STEP_MM, np.array(self._look.albedo)
        )
        self._light = Raster(found.values, found.grid.corner, found.grid.step)

    @override
    def plain(self, eye: Eye, pixels: Pixels, blur_px: float) -> Mask:
        """Say which pixels (n,) show neither an edge of the print nor one of the plate."""
        clear = self._clear_mm()
        found = [np.zeros(0, np.bool_)]
        for part in batches(pixels, 1):
            number = mi.UInt32(aligned(part))
            here, right, below = (
                self._coordinates(eye.chief_rays(number, mi.Point2f(u, v)))
                for u, v in ((0.5, 0.5), (1.5, 0.5), (0.5, 1.5))
            )
            across, down = right - here, below - here
            reach = PIXEL_REACH * (dr.norm(across) + dr.norm(down))
            reach += blur_px * _longest(across, down)
            uv, inside = clear.place(here)
            (free,) = clear.at(uv, inside)
            far = inside & (free > reach + MOST_SLANT * abs(self._plate.bow_mm))
            found.append(far.numpy())
        return np.concatenate(found)

    def _coordinates(self, ray: Vec) -> Vec:
        """Give where rays meet its middle plane, its own coordinates, mm."""
        t = dr.dot(self._origin - ray.o, self._normal) / dr.dot(ray.d, self._normal)
        return self._flat(ray(t))

    def _flat(self, point: Vec) -> Vec:
        off = point - self._origin
        return mi.Point2f(dr.dot(off, self._axes[0]), dr.dot(off, self._axes[1]))

    def _clear_mm(self) -> Raster:
        """Map how far it is to the next edge of print or plate, mm."""
        plate, ink = self._plate, _ink(self._plate.target, self._look.edge_blur_mm)
        free = _clear(plate.target, self._look.edge_blur_mm) * min(plate.print_scale)
        step = ink.step_mm * np.array(plate.print_scale)
        corner = ink.corner_mm * plate.print_scale
        columns, rows = np.floor((plate.high - plate.low) / CLEAR_STEP_MM).astype(int) + 1
        s = plate.low[0] + np.arange(columns) * CLEAR_STEP_MM
        t = plate.low[1] + np.arange(rows) * CLEAR_STEP_MM
        u = np.clip((s - corner[0]) / step[0], 0, free.shape[1] - 1)
        v = np.clip((t - corner[1]) / step[1], 0, free.shape[0] - 1)
        values = free[np.rint(v).astype(int)[:, None], np.rint(u).astype(int)]
        # Between two places the distance differs by no more than theirs.
        values = values - CLEAR_STEP_MM
        rim = np.minimum(
            np.minimum(s - plate.low[0], plate.high[0] - s),
            np.minimum(t - plate.low[1], plate.high[1] - t)[:, None],
        )
        clear = np.minimum(values, rim).astype(np.float32)
        return Raster(clear[..., None], plate.low, CLEAR_STEP_MM)

    @override
    def met(self, si: Vec) -> Vec:
        """Say which rays meet it: its sides look as its rim does."""
        front, body = self._parts
        return si.is_valid() & ((si.shape == front) | (si.shape == body))

    @override
    def slipped(self, hit: Vec, ray: Vec) -> Vec:
        """Say that no ray slips into it."""
        return mi.Mask(False)

    @override
    def radiance(
        self, world: World, backdrop: Backdrop, ray: Vec, si: Vec, points: Points, active: Vec
    ) -> list[Vec]:
        """Give what it throws back, per light group."""
        if self._light is None:
            raise RuntimeError("the board is unlit: call light first")
        st = self._flat(si.p)
        uv, printed = self._ink.place(st / self._print_scale)
        (ink,) = self._ink.at(uv, active & printed)
        albedo = self._bare + dr.select(printed, ink, 0) * (self._inked - self._bare)
        place, _ = self._light.place(st)
        return [dr.select(active, albedo * part, 0) for part in self._light.at(place, active)]


@lru_cache(maxsize=2)
def _ink(target: Target, edge_blur_mm: float) -> InkRaster:
    """Rasterise a print once for all its views."""
    return ink_raster(target, edge_blur_mm)


@lru_cache(maxsize=2)
def _clear(target: Target, edge_blur_mm: float) -> NDArray[np.float32]:
    """Give how far, mm, each texel of a print is from the next that differs from its neighbours."""
    ink = _ink(target, edge_blur_mm)
    kernel = np.ones((3, 3), np.uint8)
    same = cv2.dilate(ink.values, kernel) - cv2.erode(ink.values, kernel) < SAME
    texels = cv2.distanceTransform(same.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(texels, np.float32) * np.float32(ink.step_mm)


def _longest(a: Vec, b: Vec) -> Vec:
    """Give the greatest length of ``x a + y b`` on the circle x^2 + y^2 = 1."""
    squares, area = dr.squared_norm(a) + dr.squared_norm(b), a.x * b.y - a.y * b.x
    return dr.sqrt((squares + dr.safe_sqrt(squares**2 - 4 * area**2)) / 2)


def _thickness_px(plate: Plate, T_ct: Pose, camera: Camera) -> float:
    """Give how far apart, px, the projections of front and back edge of the rim are."""
    rim = plate.outline()
    through = np.array([0, 0, plate.thickness_mm + abs(plate.bow_mm)])
    near, far = (camera.project(T_ct.apply(points)) for points in (rim, rim + through))
    return float(np.abs(far - near).max())
