"""One view being painted: first the open background, then all that stands before it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.render.backdrop import Backdrop
from simtip.render.backend import Backend
from simtip.render.estimate import Goal
from simtip.render.look import Look
from simtip.render.noise import Noise
from simtip.render.progress import Tally
from simtip.render.subject import Mask
from simtip.render.view import Floats, View
from simtip.render.wavefront import Pixels, render_open, render_pixels
from simtip.render.world import World
from simtip.seeding import seed32

REFINED_SAMPLES = (64, 512)
"""Per pixel of background whose paper or prints leave too much noise at first."""
LATTICE_PX = 8
"""Between pixels of smooth background that are worked out, outside a crop."""


class Canvas:
    """One view being painted: first the open background, then all that stands before it."""

    def __init__(
        self, look: Look, world: World, backdrop: Backdrop, seed: int, tally: Tally
    ) -> None:
        """Paint the open background."""
        self._look = look
        self._seed = seed32(seed, look.name)
        shape = look.full.shape
        groups = len(world.lamps) + 1
        self.response = np.empty((groups, *shape, 3), np.float32)
        self.needle = np.zeros(shape, np.float32)
        self.clutter = np.zeros(shape, np.float32)
        self.open_sd = np.zeros((groups, *shape), np.float32)
        self._open(backdrop, tally)

    def _open(self, backdrop: Backdrop, tally: Tally) -> None:
        free = ~self._look.full
        if self._look.window is not None:
            outside = free.copy()
            outside[self._look.window] = False
            self._fill_up(backdrop, outside, tally)
            free &= ~outside
        pixels = np.flatnonzero(free).astype(np.uint32)
        self._paint_open(backdrop, pixels, self._look.open_samples, "open", tally)

    def _paint_open(
        self, backdrop: Backdrop, pixels: Pixels, samples: int, name: str, tally: Tally
    ) -> None:
        """Paint pixels that show only the background, with their noise."""
        gray, printed, detail = render_open(
            backdrop, self._look.eye, pixels, samples, seed32(self._seed, name), tally
        )
        albedo = backdrop.albedo.astype(np.float32)
        places = pixels.astype(np.intp)
        for k, sd in enumerate(self._map_sd(backdrop, places)):
            light = np.ascontiguousarray(gray[:, k])
            for channel, part in enumerate(albedo):  # whole triples at once take twice as long
                self.response[k].reshape(-1, 3)[places, channel] = light * part
            self.open_sd[k].reshape(-1)[places] = np.hypot(sd, detail * light) * albedo.mean()
        self.clutter.reshape(-1)[places] = printed

    def _fill_up(self, backdrop: Backdrop, where: Mask, tally: Tally) -> None:
        """Paint pixels (H, W) of plain background from a lattice of a few, in between linearly."""
        height, width = where.shape
        rows, columns = (np.arange(0, side + LATTICE_PX, LATTICE_PX) for side in (height, width))
        rows[-1], columns[-1] = height - 1, width - 1
        lattice = (rows[:, None] * width + columns).reshape(-1).astype(np.uint32)
        gray, _, _ = render_open(backdrop, self._look.eye, lattice, 1, self._seed, tally)
        v = np.interp(np.arange(height), rows, np.arange(len(rows))).astype(np.float32)
        u = np.interp(np.arange(width), columns, np.arange(len(columns))).astype(np.float32)
        u, v = np.broadcast_arrays(u, v[:, None])
        albedo = backdrop.albedo.astype(np.float32)
        for k, sd in enumerate(self._map_sd(backdrop, lattice)):
            values, spread = (
                cv2.remap(a.reshape(len(rows), -1), u.copy(), v.copy(), cv2.INTER_LINEAR)[where]
                for a in (np.ascontiguousarray(gray[:, k]), sd)
            )
            self.response[k][where] = values[:, None] * albedo
            self.open_sd[k][where] = spread * albedo.mean()

    def _map_sd(self, backdrop: Backdrop, pixels: Pixels | NDArray[np.intp]) -> list[Floats]:
        """Give the light maps' noise per group (n,) at the middle of pixels."""
        st = self._look.hits.board_st[pixels]
        return [backdrop.light_maps[0].sd_at(st, k) for k in range(backdrop.groups)]

    def refine_open(self, backdrop: Backdrop, goal: Goal, tally: Tally) -> None:
        """Paint again, with more samples, where the paper's detail leaves too much noise."""
        if goal.tolerance is None or backdrop.texture is None:
            return
        power = goal.weights.mean(axis=1)
        groups = len(self.response)
        pixels = np.flatnonzero(~self._look.full).astype(np.uint32)
        for samples in REFINED_SAMPLES:
            mixed = np.einsum(
                "gnc,gc->nc", self.response.reshape(groups, -1, 3)[:, pixels], goal.weights
            )
            # The groups share the paper: their noise adds up.
            noise = power @ self.open_sd.reshape(groups, -1)[:, pixels]
            pixels = pixels[noise > goal.tolerance(mixed)]
            tally.plan(len(pixels) * samples)
            self._paint_open(backdrop, pixels, samples, f"open {samples}", tally)

    def _map_covariance(self, backdrop: Backdrop, pixels: Pixels) -> Floats:
        """Give what the light map's noise adds (n, groups, groups) to pixels that show the board.

        Replicas do not tell: they all read the same map.
        """
        other = 1 - self.needle.reshape(-1)[pixels]
        solid = ~self._look.hits.background[pixels] & (self.needle.reshape(-1)[pixels] == 0)
        shown = backdrop.albedo.mean() * np.where(solid, 0, other)
        sd = np.stack(self._map_sd(backdrop, pixels), axis=-1) * shown[:, None]
        return np.asarray(sd[:, :, None] ** 2 * np.eye(backdrop.groups), np.float32)

    def background(self, power: Floats) -> Floats | None:
        """Give the median mixed radiance (3,) of the open background, if there is any."""
        free = np.flatnonzero(~self._look.full)
        if not len(free):
            return None
        some = free[:: max(1, len(free) // 20_000)]
        flat = self.response.reshape(len(self.response), -1, 3)[:, some]
        level: Floats = np.median(np.einsum("gnc,gc->nc", flat, power), axis=0)
        return level

    def finished(
        self, world: World, backdrop: Backdrop, goal: Goal, backend: Backend, tally: Tally
    ) -> View:
        """Sample the rest, and give the view."""
        look = self._look
        pixels = np.flatnonzero(look.full).astype(np.uint32)
        found = render_pixels(
            world, backdrop, look.eye, pixels, goal, self._seed, tally, look.reach_px
        )
        self.response[:, look.full] = np.moveaxis(found.response, 1, 0)
        self.needle[look.full] = found.needle
        self.clutter[look.full] = found.clutter
        return View(
            lamps=(*(lamp.name for lamp in world.lamps), "ambient"),
            response=self.response,
            coverage=self.needle,
            clutter=self.clutter,
            depth_mm=look.hits.depth_mm.reshape(look.full.shape),
            noise=Noise(
                self.open_sd,
                pixels,
                found.covariance + self._map_covariance(backdrop, pixels),
                found.samples,
            ),
            backend=backend.variant,
        )
