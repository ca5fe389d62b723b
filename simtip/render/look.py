"""One camera, and which of its pixels need what work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.clutter import ClutterObject
from simtip.geometry import Array, Pose
from simtip.lens import ThinLens
from simtip.render.backdrop import Plane
from simtip.render.eye import Eye
from simtip.render.subject import Mask
from simtip.render.wavefront import FirstHits, first_hits
from simtip.render.world import World
from simtip.spec import SceneSpec

EDGE_MARGIN_PX = 2.0
NEAREST_MM = 1.0
"""Nothing nearer to a camera is drawn."""
LENS_SAMPLES = 4
"""Per pixel of plain background through a lens: its light is smooth."""
PAPER_SAMPLES = 8
"""Per pixel of background with texture or prints."""

CROP_PX = 40
"""Around all that is sampled, of a crop."""


@dataclass(frozen=True, eq=False)
class Look:
    """One camera, and what it sees through its pixel centres.

    Attributes
    ----------
    name
        "left" or "right".
    camera, eye
        Its geometry.
    hits
        What lies behind pixel centres.
    full
        (H, W) pixels that need full transport; all others see only the background.
    open_samples
        Samples of those others.
    reach_px
        How far the blur of what stands before the background may reach.
    window
        Rows and columns beyond which the background is filled up smoothly; None: nowhere.
    """

    name: str
    camera: Camera
    eye: Eye
    hits: FirstHits
    full: Mask
    open_samples: int
    reach_px: float
    window: tuple[slice, slice] | None = None

    def near_background(self) -> Mask:
        """Mark pixels (n,) of background that are worked out one by one."""
        if self.window is None:
            return self.hits.background
        inside = np.zeros(self.full.shape, np.bool_)
        inside[self.window] = True
        return self.hits.background & inside.reshape(-1)


def look_through(
    spec: SceneSpec,
    world: World,
    name: str,
    camera: Camera,
    T_wc: Pose,
    lens: ThinLens | None,
    clutter: Sequence[ClutterObject],
) -> Look:
    """Sort a camera's pixels."""
    eye = Eye(camera, T_wc, lens)
    hits = first_hits(world, Plane(world.board), eye, camera.width * camera.height)
    shape = (camera.height, camera.width)
    T_cw = T_wc.inverse()
    margin = _margin(lens, camera, T_cw.apply(world.subject.vertices())[:, 2])
    if margin > max(shape) / 4:  # so much out of focus that it may reach anywhere
        full = np.ones(shape, np.bool_)
    else:
        full = world.subject.footprint(T_cw, camera, margin)
    for thing in clutter:
        if thing.in_view:
            full |= _solid(thing, T_cw, camera, lens)
    full |= _dilated(~hits.background.reshape(shape) & ~full, EDGE_MARGIN_PX)
    depth = hits.depth_mm[hits.background]
    if not hits.background.all() and lens is not None and len(depth):
        reach = _margin(lens, camera, np.array([depth.min(), depth.max()]))
        full |= _dilated(~hits.background.reshape(shape) & ~full, reach)
    samples = LENS_SAMPLES if lens is not None else 1
    paper = spec.background.textured() or spec.clutter.amounts().prints()
    window = _window(full) if spec.render.crop else None
    return Look(
        name,
        camera,
        eye,
        hits,
        full,
        PAPER_SAMPLES if paper else samples,
        margin - EDGE_MARGIN_PX,
        window,
    )


def _window(full: Mask) -> tuple[slice, slice]:
    """Frame all pixels (H, W) that are marked, and some around them."""
    sides = []
    for axis, side in zip((1, 0), full.shape, strict=True):
        marked = np.flatnonzero(full.any(axis=axis))
        low, high = (marked[0], marked[-1] + 1) if len(marked) else (0, 0)
        sides.append(slice(max(int(low) - CROP_PX, 0), min(int(high) + CROP_PX, side)))
    return sides[0], sides[1]


def _margin(lens: ThinLens | None, camera: Camera, depths_mm: Array) -> float:
    """Give how far, px, the blur of surfaces between these depths may reach."""
    if lens is None:
        return EDGE_MARGIN_PX
    focal = float(max(camera.K[0, 0], camera.K[1, 1]))
    ends = np.maximum([depths_mm.min(), depths_mm.max()], NEAREST_MM)
    return EDGE_MARGIN_PX + max(lens.blur_px(focal, float(z)) for z in ends) / 2


def _solid(thing: ClutterObject, T_cw: Pose, camera: Camera, lens: ThinLens | None) -> Mask:
    """Mark the pixels (H, W) that a piece of clutter may touch, blurred as it may be."""
    points = T_cw.apply(thing.vertices)
    canvas = np.zeros((camera.height, camera.width), np.uint8)
    near = points[:, 2] < NEAREST_MM
    faces = thing.faces[~near[thing.faces].any(axis=1)]
    if not len(faces):
        return canvas > 0
    corners = np.full((len(points), 2), 0.0)
    corners[~near] = camera.project(points[~near])
    drawn = np.rint(np.clip(corners[faces], -16_000, 16_000)).astype(np.int32)
    for triangle in drawn[_on_image(drawn, camera)]:
        cv2.fillConvexPoly(canvas, triangle, 1)
    return _dilated(canvas > 0, 1 + _margin(lens, camera, points[~near, 2]))


def _on_image(triangles: NDArray[np.int32], camera: Camera) -> Mask:
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    return np.asarray(((high >= 0) & (low < camera.size)).all(axis=1))


def _dilated(mask: Mask, margin: float) -> Mask:
    size = 2 * int(np.ceil(margin)) + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((size, size), np.uint8)) > 0
