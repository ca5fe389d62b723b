"""Both views of a scene on a vectorised back end.

Pixels that show only the background's smooth light read it from the light map; all that the needle
may touch, and all near a lamp or the background's edge, are integrated sample by sample. A lamp
thinner than a pixel may be missed.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.footprint import footprint
from simtip.geometry import Array, Pose
from simtip.lens import ThinLens
from simtip.render.backend import Backend
from simtip.render.chunks import strata
from simtip.render.eye import Eye
from simtip.render.lightmap import (
    COARSE_STEP_MM,
    Illuminator,
    LightMap,
    Lookup,
    Plane,
    light_map,
    limited_step,
)
from simtip.render.progress import Tally
from simtip.render.view import Progress, View
from simtip.render.wavefront import FirstHits, first_hits, render_open, render_pixels
from simtip.render.world import World, load_world
from simtip.seeding import seed32
from simtip.spec import SceneSpec

EDGE_MARGIN_PX = 2.0
NEAREST_MM = 1.0
"""Nothing nearer to a camera is drawn."""
OPEN_SAMPLES = 4
"""Per pixel of plain background through a lens: its light is smooth."""
FINE_POINTS_MAX = 2_000_000
COARSE_POINTS_MAX = 50_000


@dataclass(frozen=True, eq=False)
class _Look:
    """One camera, and what it sees through its pixel centres."""

    name: str
    camera: Camera
    eye: Eye
    hits: FirstHits
    full: NDArray[np.bool_]
    """(H, W) pixels that need full transport; all others see only the background."""
    open_samples: int
    """Samples of those others."""


def render_views(
    spec: SceneSpec, backend: Backend, seed: int, progress: Progress | None
) -> tuple[View, View]:
    """Render left and right; see `simtip.render.render_pair`."""
    rig = spec.rig.rig()
    world = load_world(spec)
    looks = [
        _look(spec, world, "left", rig.left, Pose.identity(), spec.rig.left.lens.thin_lens()),
        _look(spec, world, "right", rig.right, rig.T_lr, spec.rig.right.lens.thin_lens()),
    ]
    samples = strata(spec.render.samples)
    tally = Tally(progress)
    for look in looks:
        tally.plan(samples * int(look.full.sum()) + look.open_samples * int((~look.full).sum()))
    fine, coarse = _light_maps(spec, world, looks, seed, tally)
    lookup = Lookup(world.board, fine, coarse)
    left, right = (
        _view(world, lookup, look, samples, seed32(seed, look.name), tally, backend)
        for look in looks
    )
    return left, right


def _look(
    spec: SceneSpec, world: World, name: str, camera: Camera, T_wc: Pose, lens: ThinLens | None
) -> _Look:
    eye = Eye(camera, T_wc, lens)
    hits = first_hits(world, Plane(world.board), eye, camera.width * camera.height)
    shape = (camera.height, camera.width)
    needle, T_cn = spec.needle.needle(), T_wc.inverse() @ spec.needle.pose()
    vertices, _ = needle.surface()
    margin = _margin(lens, camera, T_cn.apply(vertices)[:, 2])
    if margin > max(shape) / 4:  # so much out of focus that it may reach anywhere
        full = np.ones(shape, np.bool_)
    else:
        full = footprint(needle, T_cn, camera, margin)
    full |= _dilated(~hits.background.reshape(shape) & ~full, EDGE_MARGIN_PX)
    depth = hits.depth_mm[hits.background]
    if not hits.background.all() and lens is not None and len(depth):
        reach = _margin(lens, camera, np.array([depth.min(), depth.max()]))
        full |= _dilated(~hits.background.reshape(shape) & ~full, reach)
    return _Look(name, camera, eye, hits, full, OPEN_SAMPLES if lens is not None else 1)


def _margin(lens: ThinLens | None, camera: Camera, depths_mm: Array) -> float:
    """Give how far, px, the blur of surfaces between these depths may reach."""
    if lens is None:
        return EDGE_MARGIN_PX
    focal = float(max(camera.K[0, 0], camera.K[1, 1]))
    ends = np.maximum([depths_mm.min(), depths_mm.max()], NEAREST_MM)
    return EDGE_MARGIN_PX + max(lens.blur_px(focal, float(z)) for z in ends) / 2


def _dilated(mask: NDArray[np.bool_], margin: float) -> NDArray[np.bool_]:
    size = 2 * int(np.ceil(margin)) + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((size, size), np.uint8)) > 0


def _light_maps(
    spec: SceneSpec, world: World, looks: list[_Look], seed: int, tally: Tally
) -> tuple[LightMap, LightMap]:
    """Map the part of the board in view finely and all of it coarsely, for mirror images."""
    light = Illuminator(world.scene, world.tubes, world.board)
    half = world.board.half
    seen = [look.hits.board_st[look.hits.background] for look in looks]
    places = np.concatenate(seen) if any(map(len, seen)) else np.zeros((1, 2))
    step = spec.render.light_step_mm
    low = np.maximum(places.min(axis=0) - 3 * step, -half)
    high = np.minimum(places.max(axis=0) + 3 * step, half)
    step = limited_step(low, high, step, FINE_POINTS_MAX)
    fine = light_map(light, low, high, step, seed32(seed, "light", "fine"), tally)
    coarse_step = min(COARSE_STEP_MM, float(2 * half.min()) / 4)
    coarse_step = limited_step(-half, half, coarse_step, COARSE_POINTS_MAX)
    coarse = light_map(light, -half, half, coarse_step, seed32(seed, "light", "coarse"), tally)
    return fine, coarse


def _view(
    world: World,
    lookup: Lookup,
    look: _Look,
    samples: int,
    seed: int,
    tally: Tally,
    backend: Backend,
) -> View:
    shape = look.full.shape
    response = np.empty((len(world.tubes) + 1, *shape, 3), np.float32)
    coverage = np.zeros(shape, np.float32)
    others = np.flatnonzero(~look.full).astype(np.uint32)
    light = render_open(
        lookup, look.eye, others, look.open_samples, seed32(seed, "open"), tally.add
    )
    response[:, ~look.full] = light.T[..., None] * world.albedo.astype(np.float32)
    pixels = np.flatnonzero(look.full).astype(np.uint32)
    colour, covered = render_pixels(world, lookup, look.eye, pixels, samples, seed, tally.add)
    response[:, look.full] = np.moveaxis(colour, 1, 0)
    coverage[look.full] = covered
    return View(
        lamps=(*(tube.name for tube in world.tubes), "ambient"),
        response=response,
        coverage=coverage,
        depth_mm=look.hits.depth_mm.reshape(shape),
        backend=backend.variant,
    )
