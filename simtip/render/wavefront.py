"""Render lists of pixels with vectorised (Dr.Jit) kernels, on LLVM or CUDA.

Each sample belongs to exactly one pixel (box filter over the pixel's square), so that a pixel is
the mean of its own samples: no splatting, and equal seeds give equal bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.render.backdrop import Backdrop, Plane
from simtip.render.chunks import aligned, batches, means
from simtip.render.engine import dr, mi
from simtip.render.estimate import Estimates, Goal, Layout, estimate
from simtip.render.eye import Eye
from simtip.render.progress import Tally
from simtip.render.sobol import Points, points_of
from simtip.render.transport import radiance
from simtip.render.world import World

NUDGE_PX = 1e-3

Floats = NDArray[np.float32]
Pixels = NDArray[np.uint32]


def render_pixels(
    world: World,
    backdrop: Backdrop,
    eye: Eye,
    pixels: Pixels,
    goal: Goal,
    seed: int,
    tally: Tally,
    blur_px: float,
) -> Estimates:
    """Estimate pixels in full: subject, clutter, lamps and all that lies behind.

    `blur_px` is how far the blur may reach.
    """

    def tracer(pixel: Any, points: Points) -> list[Any]:
        ray = eye.sample_rays(pixel, points)
        shares, needle, clutter = radiance(world, backdrop, ray, points)
        return [*(channel for share in shares for channel in share), needle, clutter]

    layout = Layout(eye.columns, backdrop.groups)
    plain = world.subject.plain(eye, pixels, blur_px)
    return estimate(tracer, pixels, layout, goal, seed, tally, plain)


def render_open(
    backdrop: Backdrop, eye: Eye, pixels: Pixels, samples: int, seed: int, tally: Tally
) -> tuple[Floats, Floats, Floats]:
    """Give the background at pixels that show nothing else.

    One sample is the pixel's centre seen through a pinhole.

    Returns
    -------
    gray
        (n, groups) radiance over the board's mean albedo.
    printed
        (n,) how much prints cover.
    relative_sd
        (n,) of the noise that the paper's detail makes in the mean of these samples, over the
        value; an upper estimate. Zeros where there is none.
    """
    n = len(pixels)
    found = [np.zeros((0, backdrop.groups + 2), np.float32)]
    for part in batches(pixels, samples):
        if samples == 1:
            number = mi.UInt32(aligned(part))
            ray = eye.chief_rays(number, mi.Point2f(0.5, 0.5))
        else:
            points, index = points_of(part, samples, seed)
            ray = eye.sample_rays(dr.gather(mi.UInt32, mi.UInt32(part), index), points)
        shares, prints = backdrop.gray(backdrop.meet(ray), mi.Mask(True))
        total = shares[0]
        for share in shares[1:]:
            total = total + share
        prints = prints + dr.zeros(mi.Float, dr.width(total))
        found.append(means([*shares, prints, total * total], samples))
        tally.add(len(part) * samples)
    every: Floats = np.concatenate(found)
    gray, printed, squares = every[:, :-2], every[:, -2], every[:, -1]
    if backdrop.texture is None or samples == 1:
        return gray, printed, np.zeros(n, np.float32)
    mean = gray.sum(axis=1, dtype=np.float32)
    variance = np.maximum(squares - mean**2, 0) / np.float32(samples - 1)
    relative: Floats = np.sqrt(variance) / np.maximum(mean, np.float32(1e-30))
    return gray, printed, relative


@dataclass(frozen=True, eq=False)
class FirstHits:
    """What lies behind pixel centres, each (n,)."""

    depth_mm: Floats
    """Camera z of the nearest surface; inf where there is none."""
    background: NDArray[np.bool_]
    """Whether that is the background's lit side."""
    subject: NDArray[np.bool_]
    """Whether that is the subject's."""
    board_st: Floats
    """(n, 2) where the ray meets the background's plane, board coordinates, mm."""


def first_hits(world: World, plane: Plane, eye: Eye, pixels: int) -> FirstHits:
    """Look through pixel centres."""
    depths, boards, subjects, places = [], [], [], []
    for part in batches(np.arange(pixels, dtype=np.uint32), 1):
        number = mi.UInt32(aligned(part))
        ray = eye.chief_rays(number, mi.Point2f(0.5, 0.5))
        hit = world.scene.ray_intersect(ray)
        # One ray in a thousand slips between two of the needle's thin triangles and meets its far
        # wall from inside; a hair's breadth beside it another does not.
        inside = world.subject.slipped(hit, ray)
        beside = eye.chief_rays(number, mi.Point2f(0.5 + NUDGE_PX, 0.5 + NUDGE_PX))
        t = dr.select(inside, world.scene.ray_intersect_preliminary(beside, inside).t, hit.t)
        z = dr.select(hit.is_valid(), t * dr.dot(ray.d, eye.axes[2]), dr.inf)
        board = hit.is_valid() & (hit.shape == world.background)
        board &= dr.dot(ray.d, world.board_normal) < 0
        met = world.subject.met(hit)
        st = plane.coordinates(plane.meet(ray))
        dr.eval(z, board, met, st)
        depths.append(z.numpy())
        boards.append(board.numpy())
        subjects.append(met.numpy())
        places.append(np.stack([st.x.numpy(), st.y.numpy()], axis=-1))
    return FirstHits(*map(np.concatenate, (depths, boards, subjects, places)))
