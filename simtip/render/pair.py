"""Both views of a scene on a vectorised back end.

Pixels that show only the background's smooth light read it from the light map; all that the needle,
a lamp or the background's edge may touch are integrated sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.footprint import footprint
from simtip.geometry import Array, Pose
from simtip.render.backend import Backend
from simtip.render.chunks import strata
from simtip.render.lightmap import (
    COARSE_STEP_MM,
    Illuminator,
    LightMap,
    Lookup,
    light_map,
)
from simtip.render.progress import Tally
from simtip.render.view import Progress, View
from simtip.render.wavefront import Eye, first_hits, render_pixels
from simtip.render.world import World, load_world
from simtip.seeding import seed32
from simtip.spec import SceneSpec

EDGE_MARGIN_PX = 2
FINE_POINTS_MAX = 2_000_000


@dataclass(frozen=True, eq=False)
class _Look:
    """What one camera sees through its pixel centres."""

    name: str
    camera: Camera
    T_wc: Pose
    eye: Eye
    depth_mm: NDArray[np.float32]
    board_st: Array
    """(H, W, 2) board coordinates, mm."""
    full: NDArray[np.bool_]
    """(H, W) pixels that need full transport; all others see only the background."""


def render_views(
    spec: SceneSpec, backend: Backend, seed: int, progress: Progress | None
) -> tuple[View, View]:
    """Render left and right; see `simtip.render.render_pair`."""
    rig = spec.rig.rig()
    world = load_world(spec)
    looks = [
        _look(spec, world, "left", rig.left, Pose.identity()),
        _look(spec, world, "right", rig.right, rig.T_lr),
    ]
    samples = strata(spec.render.samples)
    tally = Tally(progress)
    tally.plan(samples * sum(int(look.full.sum()) for look in looks))
    fine, coarse = _light_maps(spec, world, looks, seed, tally)
    lookup = Lookup(world.board, fine, coarse)
    left, right = (
        _view(world, lookup, fine, look, samples, seed32(seed, look.name), tally, backend)
        for look in looks
    )
    return left, right


def _look(spec: SceneSpec, world: World, name: str, camera: Camera, T_wc: Pose) -> _Look:
    eye = Eye(camera, T_wc)
    depth, board = first_hits(world, eye, camera.width * camera.height)
    shape = (camera.height, camera.width)
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = T_wc.rotate(camera.rays(np.stack([u, v], axis=-1)))
    other = (~board.reshape(shape)).astype(np.uint8)
    size = 2 * EDGE_MARGIN_PX + 1
    full = cv2.dilate(other, np.ones((size, size), np.uint8)) > 0
    T_cn = T_wc.inverse() @ spec.needle.pose()
    full |= footprint(spec.needle.needle(), T_cn, camera, EDGE_MARGIN_PX)
    board_st = world.board.meet(T_wc.t, rays)
    return _Look(name, camera, T_wc, eye, depth.reshape(shape), board_st, full)


def _light_maps(
    spec: SceneSpec, world: World, looks: list[_Look], seed: int, tally: Tally
) -> tuple[LightMap, LightMap]:
    """Map the part of the board in view finely and all of it coarsely, for mirror images."""
    light = Illuminator(world.scene, world.tubes, world.board)
    half = world.board.half
    seen = [look.board_st[~look.full] for look in looks if not look.full.all()]
    places = np.concatenate(seen) if seen else np.zeros((1, 2))
    step = spec.render.light_step_mm
    low = np.maximum(places.min(axis=0) - 3 * step, -half)
    high = np.minimum(places.max(axis=0) + 3 * step, half)
    step = max(step, float(np.sqrt(np.prod(high - low) / FINE_POINTS_MAX)))
    fine = light_map(light, low, high, step, seed32(seed, "light", "fine"), tally)
    coarse_step = min(COARSE_STEP_MM, float(2 * half.min()) / 4)
    coarse = light_map(light, -half, half, coarse_step, seed32(seed, "light", "coarse"), tally)
    return fine, coarse


def _view(
    world: World,
    lookup: Lookup,
    light: LightMap,
    look: _Look,
    samples: int,
    seed: int,
    tally: Tally,
    backend: Backend,
) -> View:
    albedo = world.albedo.astype(np.float32)
    response = np.moveaxis(light.at(look.board_st), -1, 0)[..., None] * albedo
    coverage = np.zeros(look.full.shape, np.float32)
    pixels = np.flatnonzero(look.full).astype(np.uint32)
    colour, covered = render_pixels(world, lookup, look.eye, pixels, samples, seed, tally.add)
    response[:, look.full] = np.moveaxis(colour, 1, 0)
    coverage[look.full] = covered
    return View(
        lamps=(*(tube.name for tube in world.tubes), "ambient"),
        response=response,
        coverage=coverage,
        depth_mm=look.depth_mm,
        backend=backend.variant,
    )
