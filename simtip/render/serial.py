"""Both views on Mitsuba's scalar variant, with its stock integrators: slow, for want of a better.

The same transport as `simtip.render.transport`, put together from two stock renders, per lamp:
what is not the needle, directly lit (`direct`, with the needle as a black occluder), and the needle
with what it mirrors (`path` to three segments, all else clipped away). So it doubles as an
independent check of the vectorised renderer.

Mitsuba's perspective camera has square pixels. Each image row is therefore a film of its own with
f = fx, placed so that the row's centre lies exactly where fy puts it; the rows' height is then off
by the factor fy/fx (0.5 % at the paper's rig), which moves no edge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.errors import BackendError
from simtip.footprint import footprint
from simtip.geometry import Array, Pose
from simtip.render.backend import Backend
from simtip.render.board import Board
from simtip.render.engine import mi
from simtip.render.noise import Noise
from simtip.render.progress import Tally
from simtip.render.stock import stock_scene
from simtip.render.view import Progress, Tolerance, View
from simtip.seeding import seed32
from simtip.spec import PointLamp, SceneSpec

Floats = NDArray[np.float32]

SAMPLES_OPEN = 16
SAMPLES_NEEDLE = 256
"""At most: it has no noise to aim at."""
MARGIN_PX = 2
SMOOTH_PX = 3
FAR_MM = 1e5
BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}


@dataclass(frozen=True, eq=False)
class Rows:
    """Part of an image: from row `top` on, `width` columns from `starts` in each row.

    Nothing is seen beyond the camera z `far_mm` of each row.
    """

    top: int
    starts: NDArray[np.intp]
    width: int
    far_mm: Array

    @property
    def pixels(self) -> int:
        """How many there are."""
        return len(self.starts) * self.width


def whole_image(camera: Camera) -> Rows:
    """Take all columns of all rows."""
    rows = camera.height
    return Rows(0, np.zeros(rows, np.intp), camera.width, np.full(rows, FAR_MM))


class RowCamera:
    """Mitsuba's perspective camera on some rows of an image, one row at a time."""

    def __init__(self, camera: Camera, T_wc: Pose, rows: Rows) -> None:
        self._K = camera.K
        self._rows = rows
        to_world = np.eye(4)
        # Mitsuba's camera has x to the left and y up.
        to_world[:3, :3] = T_wc.R @ np.diag([-1.0, -1.0, 1.0])
        to_world[:3, 3] = T_wc.t
        self._sensor = mi.load_dict(
            {
                "type": "perspective",
                "to_world": mi.ScalarTransform4f(to_world),
                "fov": float(np.degrees(2 * np.arctan(rows.width / 2 / camera.K[0, 0]))),
                "fov_axis": "x",
                "near_clip": 1.0,
                "film": {
                    "type": "hdrfilm",
                    "width": rows.width,
                    "height": 1,
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                    "component_format": "float32",
                },
                "sampler": {"type": "multijitter", "sample_count": 1},
            }
        )
        self._parameters = mi.traverse(self._sensor)

    def render(self, scene: Any, integrator: Any, samples: int, seed: int, tally: Tally) -> Floats:
        """Render all rows: (rows, width, 3)."""
        K, rows = self._K, self._rows
        image = np.empty((len(rows.starts), rows.width, 3), np.float32)
        for k, start in enumerate(rows.starts):
            # A film spans [0, width); pixel centres lie half a pixel in.
            offset = 0.5 - (K[0, 2] + 0.5 - start) / rows.width
            slope = (rows.top + k - K[1, 2]) / K[1, 1]
            self._parameters["principal_point_offset_x"] = float(offset)
            self._parameters["principal_point_offset_y"] = float(slope * K[0, 0])
            self._parameters["far_clip"] = float(rows.far_mm[k])
            self._parameters.update()
            picture = mi.render(
                scene, sensor=self._sensor, integrator=integrator, spp=samples, seed=seed32(seed, k)
            )
            image[k] = np.array(picture)[0, :, :3]
            tally.add(samples * rows.width)
        return image

    def paste(self, part: Floats, into: Floats, *, over: bool = False) -> None:
        """Add rendered rows (rows, width, ...) to an image (H, W, ...), or put them over it."""
        for k, start in enumerate(self._rows.starts):
            place = into[self._rows.top + k, start : start + self._rows.width]
            place[...] = part[k] if over else place + part[k]


def render_views(
    spec: SceneSpec,
    backend: Backend,
    seed: int,
    tolerance: Tolerance | None,  # noqa: ARG001 (here the number of samples is fixed)
    progress: Progress | None,
) -> tuple[View, View]:
    """Render left and right; see `simtip.render.render_pair`."""
    _require_simple(spec)
    rig = spec.rig.rig()
    tally = Tally(progress)
    jobs = [("left", rig.left, Pose.identity()), ("right", rig.right, rig.T_lr)]
    groups = len(spec.lamps) + 1
    masks = [
        footprint(spec.needle.needle(), T_wc.inverse() @ spec.needle.pose(), camera, MARGIN_PX)
        for _, camera, T_wc in jobs
    ]
    samples = _strata(min(spec.render.samples, SAMPLES_NEEDLE))
    for mask in masks:
        tally.plan(groups * mask.size * SAMPLES_OPEN)
        tally.plan((2 * groups + 1) * _around(mask).pixels * samples)
    left, right = (
        _render_view(spec, camera, T_wc, mask, samples, seed32(seed, name), tally, backend)
        for (name, camera, T_wc), mask in zip(jobs, masks, strict=True)
    )
    tally.finish()
    return left, right


def _require_simple(spec: SceneSpec) -> None:
    """Refuse what stock integrators and a pinhole by rows cannot do."""
    cameras = (spec.rig.left, spec.rig.right)
    beyond = {
        "lens.distortion": any(camera.lens.distortion for camera in cameras),
        "lens.focus_mm": any(camera.lens.focus_mm is not None for camera in cameras),
        "room": spec.room is not None,
        "clutter": spec.clutter != type(spec.clutter)(),
        "a textured background": spec.background.textured() or spec.background.wrinkles,
        "roughness_along": spec.needle.material.roughness_along is not None,
        "point lamps": any(isinstance(lamp, PointLamp) for lamp in spec.lamps),
    }
    asked = [name for name, is_asked in beyond.items() if is_asked]
    if asked:
        raise BackendError(
            f"the scalar back end does not render {', '.join(asked)}; "
            "`simtip doctor` says how to get another"
        )


def _unknown_noise(shape: tuple[int, ...]) -> Noise:
    """Say that the error is not known: NaN everywhere."""
    none = np.zeros(0, np.uint32)
    groups = shape[0]
    return Noise(
        np.full(shape, np.nan, np.float32), none, np.zeros((0, groups, groups), np.float32), none
    )


def _strata(samples: int) -> int:
    """Round a sample count up to one that can be stratified in two dimensions."""
    return int(mi.load_dict({"type": "multijitter", "sample_count": samples}).sample_count())


def _around(mask: NDArray[np.bool_]) -> Rows:
    """Take one stretch around what is marked in each row, all equally wide."""
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return Rows(0, np.zeros(0, np.intp), 1, np.zeros(0))
    part = mask[rows[0] : rows[-1] + 1]
    first = part.argmax(axis=1)
    last = part.shape[1] - 1 - part[:, ::-1].argmax(axis=1)
    width = int((last - first).max()) + 1
    starts = np.clip(first, 0, part.shape[1] - width)
    return Rows(int(rows[0]), starts, width, np.full(len(starts), FAR_MM))


def _render_view(
    spec: SceneSpec,
    camera: Camera,
    T_wc: Pose,
    mask: NDArray[np.bool_],
    samples: int,
    seed: int,
    tally: Tally,
    backend: Backend,
) -> View:
    height, width = mask.shape
    whole = RowCamera(camera, T_wc, whole_image(camera))
    around = RowCamera(camera, T_wc, _around(mask))
    smooth = _only_background(spec, camera, T_wc) & ~mask
    close = RowCamera(camera, T_wc, _clipped(_around(mask), spec, camera, T_wc))
    direct = mi.load_dict({"type": "direct"})
    path = mi.load_dict({"type": "path", "max_depth": 3, "rr_depth": 99, "hide_emitters": True})
    lamps = (*(lamp.name for lamp in spec.lamps), "ambient")
    response = np.empty((len(lamps), height, width, 3), np.float32)
    for k, lamp in enumerate(lamps):
        scene = mi.load_dict(stock_scene(spec, lit=lamp, metal=BLACK), parallel=False)
        open_light = whole.render(scene, direct, SAMPLES_OPEN, seed32(seed, lamp, "open"), tally)
        response[k] = np.where(smooth[..., None], _smoothed(open_light, smooth), open_light)
        behind = around.render(scene, direct, samples, seed32(seed, lamp, "behind"), tally)
        around.paste(behind, response[k], over=True)
        scene = mi.load_dict(stock_scene(spec, lit=lamp), parallel=False)
        needle = close.render(scene, path, samples, seed32(seed, lamp, "needle"), tally)
        close.paste(needle, response[k])
    coverage = np.zeros(mask.shape, np.float32)
    glowing = mi.load_dict(stock_scene(spec, lit="needle", metal=BLACK), parallel=False)
    shine = close.render(glowing, direct, samples, seed32(seed, "coverage"), tally)
    close.paste(shine[..., 0], coverage)
    return View(
        lamps=lamps,
        response=response,
        coverage=coverage,
        clutter=np.zeros(mask.shape, np.float32),
        depth_mm=_depth(spec, glowing, camera, T_wc, mask),
        noise=_unknown_noise(response.shape[:3]),
        backend=backend.variant,
    )


def _only_background(spec: SceneSpec, camera: Camera, T_wc: Pose) -> NDArray[np.bool_]:
    """Mark pixels (H, W) whose surroundings, too, lie on the background."""
    v, u = np.mgrid[: camera.height, : camera.width]
    rays: Array = T_wc.rotate(camera.rays(np.stack([u, v], axis=-1)))
    board = Board.of(spec.background)
    with np.errstate(invalid="ignore"):
        on_it = (np.abs(board.meet(T_wc.t, rays)) < board.half).all(axis=-1)
    size = 2 * SMOOTH_PX + 1
    inner = cv2.erode(np.asarray(on_it, np.uint8), np.ones((size, size), np.uint8))
    return np.asarray(inner > 0)


def _smoothed(light: Floats, where: NDArray[np.bool_]) -> Floats:
    """Average over neighbours that count: the background's light changes slowly.

    Over about as many pixels as the step of the vectorised renderer's light map.
    """
    size = (2 * SMOOTH_PX + 1,) * 2
    weight = cv2.blur(where.astype(np.float32), size)
    total = cv2.blur(light * where[..., None].astype(np.float32), size)
    return np.asarray(total / np.maximum(weight, 1e-6)[..., None], np.float32)


def _clipped(rows: Rows, spec: SceneSpec, camera: Camera, T_wc: Pose) -> Rows:
    """Set each row's end of sight between the needle and the background behind it."""
    vertices, _ = spec.needle.needle().surface()
    T_cn = T_wc.inverse() @ spec.needle.pose()
    needle_z = float(T_cn.apply(vertices)[:, 2].max())
    v = rows.top + np.arange(len(rows.starts))
    ends = np.stack([rows.starts - 0.5, rows.starts + rows.width - 0.5])
    rays = camera.rays(np.stack([ends, np.broadcast_to(v, ends.shape)], axis=-1))
    board = Board.of(spec.background)
    points = board.points(board.meet(T_wc.t, T_wc.rotate(rays)))
    z = T_wc.inverse().apply(points)[..., 2]
    board_z = np.where(np.isnan(z), np.inf, z).min(axis=0)
    if (board_z <= needle_z).any():
        raise BackendError(
            "the scalar back end needs the background to lie behind the whole needle in depth "
            f"({board_z.min():.1f} <= {needle_z:.1f} mm); `simtip doctor` says how to get another"
        )
    return replace(rows, far_mm=np.minimum((needle_z + board_z) / 2, FAR_MM))


def _depth(
    spec: SceneSpec,
    scene: Any,
    camera: Camera,
    T_wc: Pose,
    mask: NDArray[np.bool_],
) -> Floats:
    """Camera z at pixel centres: the plane's where it is all there is, else by tracing rays."""
    v, u = np.mgrid[: camera.height, : camera.width]
    rays: Array = T_wc.rotate(camera.rays(np.stack([u, v], axis=-1)))
    board = Board.of(spec.background)
    st = board.meet(T_wc.t, rays)
    depth: Floats = T_wc.inverse().apply(board.points(st))[..., 2].astype(np.float32)
    forward = T_wc.R[:, 2]
    trace = mask | ~(np.abs(st) < board.half).all(axis=-1)
    origin = mi.Point3f(*T_wc.t)
    for row, column in np.argwhere(trace):
        direction = rays[row, column]
        hit = scene.ray_intersect_preliminary(mi.Ray3f(origin, mi.Vector3f(*direction)))
        depth[row, column] = hit.t * float(direction @ forward) if hit.is_valid() else np.inf
    return depth
