"""Render lists of pixels with vectorised (Dr.Jit) kernels, on LLVM or CUDA.

Each sample belongs to exactly one pixel (box filter over the pixel's square), so that a pixel is
the mean of its own samples: no splatting, and equal seeds give equal bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.render.chunks import Report, batches, means, stratified
from simtip.render.engine import dr, mi
from simtip.render.lightmap import Lookup
from simtip.render.transport import radiance
from simtip.render.world import World
from simtip.seeding import seed32

Floats = NDArray[np.float32]
Pixels = NDArray[np.uint32]


class Eye:
    """A camera in the renderer's own numbers, opaque so that kernels are shared by all cameras."""

    def __init__(self, camera: Camera, T_wc: Pose) -> None:
        K = camera.K
        self.width = dr.opaque(mi.UInt32, camera.width)
        self.fx, self.fy, self.cx, self.cy = (
            dr.opaque(mi.Float, float(v)) for v in (K[0, 0], K[1, 1], K[0, 2], K[1, 2])
        )
        self.axes = [
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in column]) for column in T_wc.R.T
        ]
        self.origin = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in T_wc.t])

    def rays(self, pixel: Any, offset: Any) -> Any:
        """Rays through pixels (index v * width + u), `offset` in [0, 1)^2 across each square.

        (0.5, 0.5) is the pixel's centre, which is where OpenCV's integer coordinates lie.
        """
        v = pixel // self.width
        u = pixel - v * self.width
        x = ((mi.Float(u) - self.cx) + (offset.x - 0.5)) / self.fx
        y = ((mi.Float(v) - self.cy) + (offset.y - 0.5)) / self.fy
        direction = x * self.axes[0] + y * self.axes[1] + self.axes[2]
        return mi.Ray3f(self.origin, dr.normalize(direction))


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
        ray = eye.rays(dr.gather(mi.UInt32, mi.UInt32(part), index), sampler.next_2d())
        shares, needle = radiance(world, light, ray, sampler)
        flat = [channel for share in shares for channel in share]
        found = means([*flat, dr.select(needle, mi.Float(1), 0)], samples)
        lights.append(found[:, :-1].reshape(len(part), -1, 3))
        covers.append(found[:, -1])
        report(len(part) * samples)
    if not lights:
        return np.zeros((0, len(world.tubes) + 1, 3), np.float32), np.zeros(0, np.float32)
    return np.concatenate(lights), np.concatenate(covers)


def first_hits(world: World, eye: Eye, pixels: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Look through pixel centres.

    Returns
    -------
    tuple
        (n,) camera z, mm, of the nearest surface, inf where there is none; (n,) whether that is
        the background's lit side.
    """
    depths, boards = [], []
    for part in batches(np.arange(pixels, dtype=np.uint32), 1):
        ray = eye.rays(mi.UInt32(part), mi.Point2f(0.5, 0.5))
        hit = world.scene.ray_intersect_preliminary(ray)
        z = dr.select(hit.is_valid(), hit.t * dr.dot(ray.d, eye.axes[2]), dr.inf)
        board = hit.is_valid() & (hit.shape == world.background)
        board &= dr.dot(ray.d, world.board_normal) < 0
        dr.eval(z, board)
        depths.append(z.numpy())
        boards.append(board.numpy())
    return np.concatenate(depths), np.concatenate(boards)
