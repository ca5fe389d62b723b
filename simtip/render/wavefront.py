"""Render lists of pixels with vectorised (Dr.Jit) kernels, on LLVM or CUDA.

Each sample belongs to exactly one pixel (box filter over the pixel's square), so that a pixel is
the mean of its own samples: no splatting, and equal seeds give equal bits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.render.chunks import Report, batches, means, stratified
from simtip.render.engine import dr, mi
from simtip.render.eye import Eye
from simtip.render.lightmap import Lookup, Plane
from simtip.render.transport import radiance
from simtip.render.world import World
from simtip.seeding import seed32

NUDGE_PX = 1e-3

Floats = NDArray[np.float32]
Pixels = NDArray[np.uint32]


def render_pixels(
    world: World,
    light: Lookup,
    eye: Eye,
    pixels: Pixels,
    samples: int,
    seed: int,
    report: Report,
) -> tuple[Floats, Floats]:
    """Radiance (n, lamps + 1, 3) per unit lamp radiance and needle coverage (n,) of pixels."""
    lights, covers = [], []
    for k, part in enumerate(batches(pixels, samples)):
        sampler, index = stratified(len(part), samples, seed32(seed, k))
        ray = eye.sample_rays(dr.gather(mi.UInt32, mi.UInt32(part), index), sampler)
        shares, needle = radiance(world, light, ray, sampler)
        flat = [channel for share in shares for channel in share]
        found = means([*flat, dr.select(needle, mi.Float(1), 0)], samples)
        lights.append(found[:, :-1].reshape(len(part), -1, 3))
        covers.append(found[:, -1])
        report(len(part) * samples)
    if not lights:
        return np.zeros((0, len(world.tubes) + 1, 3), np.float32), np.zeros(0, np.float32)
    return np.concatenate(lights), np.concatenate(covers)


def render_open(
    light: Lookup, eye: Eye, pixels: Pixels, samples: int, seed: int, report: Report
) -> Floats:
    """Irradiance / pi of the background (n, lamps + 1) at pixels that show nothing else.

    One sample is the pixel's centre seen through a pinhole.
    """
    parts = [np.zeros((0, light.groups), np.float32)]
    for k, part in enumerate(batches(pixels, samples)):
        if samples == 1:
            ray = eye.chief_rays(mi.UInt32(part), mi.Point2f(0.5, 0.5))
        else:
            sampler, index = stratified(len(part), samples, seed32(seed, k))
            ray = eye.sample_rays(dr.gather(mi.UInt32, mi.UInt32(part), index), sampler)
        parts.append(means(light.at(light.meet(ray), mi.Mask(True)), samples))
        report(len(part) * samples)
    return np.concatenate(parts)


@dataclass(frozen=True, eq=False)
class FirstHits:
    """What lies behind pixel centres, each (n,)."""

    depth_mm: Floats
    """Camera z of the nearest surface; inf where there is none."""
    background: NDArray[np.bool_]
    """Whether that is the background's lit side."""
    board_st: Floats
    """(n, 2) where the ray meets the background's plane, board coordinates, mm."""


def first_hits(world: World, light_plane: Plane, eye: Eye, pixels: int) -> FirstHits:
    """Look through pixel centres."""
    depths, boards, places = [], [], []
    for part in batches(np.arange(pixels, dtype=np.uint32), 1):
        ray = eye.chief_rays(mi.UInt32(part), mi.Point2f(0.5, 0.5))
        hit = world.scene.ray_intersect(ray)
        # One ray in a thousand slips between two of the needle's thin triangles and meets its far
        # wall from inside; a hair's breadth beside it another does not.
        inside = hit.is_valid() & (hit.instance == world.needle) & (dr.dot(hit.n, ray.d) > 0)
        beside = eye.chief_rays(mi.UInt32(part), mi.Point2f(0.5 + NUDGE_PX, 0.5 + NUDGE_PX))
        t = dr.select(inside, world.scene.ray_intersect_preliminary(beside, inside).t, hit.t)
        z = dr.select(hit.is_valid(), t * dr.dot(ray.d, eye.axes[2]), dr.inf)
        board = hit.is_valid() & (hit.shape == world.background)
        board &= dr.dot(ray.d, world.board_normal) < 0
        st = light_plane.coordinates(light_plane.meet(ray))
        dr.eval(z, board, st)
        depths.append(z.numpy())
        boards.append(board.numpy())
        places.append(np.stack([st.x.numpy(), st.y.numpy()], axis=-1))
    return FirstHits(np.concatenate(depths), np.concatenate(boards), np.concatenate(places))
