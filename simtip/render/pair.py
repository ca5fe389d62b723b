"""Both views of a scene on a vectorised back end.

Pixels that show only the background's smooth light read it from the light map; all that the needle
may touch, all clutter, and all near a lamp or the background's edge, are sampled one by one until
their noise is as small as asked. A lamp thinner than a pixel may be missed.
"""

from __future__ import annotations

import cv2
import numpy as np

from simtip.clutter import BoardTexture, ClutterObject, board_texture, grouped, objects
from simtip.geometry import Array, Pose
from simtip.mix import weights
from simtip.render.backdrop import Backdrop
from simtip.render.backend import Backend
from simtip.render.estimate import Estimates, Goal
from simtip.render.lightmap import COARSE_STEP_MM, Illuminator, LightMap, light_map, limited_step
from simtip.render.look import Look, look_through
from simtip.render.noise import Noise
from simtip.render.progress import Tally
from simtip.render.setting import clutter_setting
from simtip.render.view import Floats, Progress, Tolerance, View
from simtip.render.wavefront import Pixels, render_open, render_pixels
from simtip.render.world import World, load_world
from simtip.seeding import seed32
from simtip.spec import SceneSpec

FINE_POINTS_MAX = 2_000_000
COARSE_POINTS_MAX = 50_000
REFINED_SAMPLES = (64, 512)
"""Per pixel of background whose paper or prints leave too much noise at first."""


def render_views(
    spec: SceneSpec,
    backend: Backend,
    seed: int,
    tolerance: Tolerance | None,
    progress: Progress | None,
) -> tuple[View, View]:
    """Render left and right; see `simtip.render.render_pair`."""
    rig = spec.rig.rig()
    clutter = solid_clutter(spec)
    world = load_world(spec, seed, clutter)
    lenses = spec.rig.left.lens.thin_lens(), spec.rig.right.lens.thin_lens()
    left = look_through(spec, world, "left", rig.left, Pose.identity(), lenses[0], clutter)
    right = look_through(spec, world, "right", rig.right, rig.T_lr, lenses[1], clutter)
    looks = [left, right]
    tally = Tally(progress)
    for look in looks:
        tally.plan(look.open_samples * int((~look.full).sum()))
    low, high = _seen_box(spec, world, looks)
    backdrop = Backdrop(
        world.board,
        np.array(spec.background.albedo),
        _light_maps(spec, world, low, high, seed, tally),
        _texture(spec, low, high),
        tuple(np.array(lamp.centre_mm) for lamp in spec.lamps),
    )
    canvases = [_Canvas(look, world, backdrop, seed, tally) for look in looks]
    goal = _goal(spec, canvases, tolerance)
    for canvas in canvases:
        canvas.refine_open(backdrop, goal, tally)
    left_view, right_view = (
        canvas.finished(world, backdrop, goal, backend, tally) for canvas in canvases
    )
    return left_view, right_view


def solid_clutter(spec: SceneSpec) -> tuple[ClutterObject, ...]:
    """Give a scene's solid clutter as meshes, those of one look joined."""
    return grouped(objects(spec.clutter, clutter_setting(spec), spec.seed))


def _seen_box(spec: SceneSpec, world: World, looks: list[Look]) -> tuple[Array, Array]:
    """Give the box (low, high) of the board that holds all of it that is in view."""
    half = world.board.half
    seen = [look.hits.board_st[look.hits.background] for look in looks]
    places = np.concatenate(seen) if any(map(len, seen)) else np.zeros((1, 2))
    margin = 3 * spec.render.light_step_mm
    return (
        np.maximum(places.min(axis=0) - margin, -half),
        np.minimum(places.max(axis=0) + margin, half),
    )


def _light_maps(
    spec: SceneSpec, world: World, low: Array, high: Array, seed: int, tally: Tally
) -> tuple[LightMap, LightMap]:
    """Map the part of the board in view finely and all of it coarsely, for mirror images."""
    height = 0.0 if world.clutter else _needle_height_mm(spec, world)
    light = Illuminator(world.scene, world.lamps, world.surround, world.board, height)
    half = world.board.half
    step = limited_step(low, high, spec.render.light_step_mm, FINE_POINTS_MAX)
    fine = light_map(light, low, high, step, seed32(seed, "light", "fine"), tally)
    coarse_step = min(COARSE_STEP_MM, float(2 * half.min()) / 4)
    coarse_step = limited_step(-half, half, coarse_step, COARSE_POINTS_MAX)
    coarse = light_map(light, -half, half, coarse_step, seed32(seed, "light", "coarse"), tally)
    return fine, coarse


def _needle_height_mm(spec: SceneSpec, world: World) -> float:
    vertices, _ = spec.needle.needle().surface()
    heights = (spec.needle.pose().apply(vertices) - world.board.centre) @ world.board.normal
    return float(heights.min())


def _texture(spec: SceneSpec, low: Array, high: Array) -> BoardTexture | None:
    return board_texture(spec.background, spec.clutter, spec.seed, low, high)


def _goal(spec: SceneSpec, canvases: list[_Canvas], tolerance: Tolerance | None) -> Goal:
    """Turn what is asked for into numbers: the mix that is judged, and how far it may be off."""
    power = weights(spec, 1)
    mean = np.stack([np.asarray(w).reshape(-1, 3)[0] for w in power.values()]).astype(np.float32)
    if tolerance is None or spec.render.noise is None:
        return Goal(spec.render.samples, mean)
    levels = [canvas.background(mean) for canvas in canvases]
    known = [level for level in levels if level is not None]
    background = np.mean(known, axis=0) if known else None
    allowed = tolerance

    def permitted(radiance: Floats) -> Floats:
        return allowed(radiance, background)

    return Goal(spec.render.samples, mean, permitted)


class _Canvas:
    """One view being painted: first the open background, then all that stands before it."""

    def __init__(
        self, look: Look, world: World, backdrop: Backdrop, seed: int, tally: Tally
    ) -> None:
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
        free = np.flatnonzero(~self._look.full).astype(np.uint32)
        self._paint_open(backdrop, free, self._look.open_samples, "open", tally)

    def _paint_open(
        self, backdrop: Backdrop, pixels: Pixels, samples: int, name: str, tally: Tally
    ) -> None:
        """Paint pixels that show only the background, with their noise."""
        look, groups = self._look, len(self.response)
        gray, printed, detail = render_open(
            backdrop, look.eye, pixels, samples, seed32(self._seed, name), tally
        )
        albedo = backdrop.albedo.astype(np.float32)
        fine = backdrop.light_maps[0]
        st = look.hits.board_st[pixels]
        u, v = ((st - fine.grid.corner) / fine.grid.step).astype(np.float32).T
        self.response.reshape(groups, -1, 3)[:, pixels] = gray.T[..., None] * albedo
        for k in range(groups):
            sd = _at(fine.sd[..., k], u, v)
            noise = np.hypot(sd, detail * gray[:, k]) * albedo.mean()
            self.open_sd[k].reshape(-1)[pixels] = noise
        self.clutter.reshape(-1)[pixels] = printed

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

    def _map_variance(self, backdrop: Backdrop, pixels: Pixels) -> Floats:
        """Give what the light map's noise adds (n, groups, groups) to pixels that show the board.

        Replicas do not tell: they all read the same map.
        """
        fine = backdrop.light_maps[0]
        u, v = ((self._look.hits.board_st[pixels] - fine.grid.corner) / fine.grid.step).T
        shown = backdrop.albedo.mean() * (1 - self.needle.reshape(-1)[pixels])
        sd = [_at(fine.sd[..., k], u.astype(np.float32), v.astype(np.float32)) * shown
              for k in range(backdrop.groups)]  # fmt: skip
        diagonal = np.stack(sd, axis=-1)[:, :, None] ** 2 * np.eye(backdrop.groups)
        return np.asarray(diagonal, np.float32)

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
        """Sample the rest."""
        look = self._look
        pixels = np.flatnonzero(look.full).astype(np.uint32)
        found: Estimates = render_pixels(world, backdrop, look.eye, pixels, goal, self._seed, tally)
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
                found.covariance + self._map_variance(backdrop, pixels),
                found.samples,
            ),
            backend=backend.variant,
        )


def _at(layer: Floats, u: Floats, v: Floats) -> Floats:
    """Read a grid (rows, columns) at places (n,), between its points."""
    found = [
        cv2.remap(
            np.ascontiguousarray(layer), a[None], b[None], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )[0]
        for a, b in zip(_pieces(u), _pieces(v), strict=True)
    ]  # fmt: skip
    return np.concatenate(found) if found else np.zeros(0, np.float32)


def _pieces(values: Floats) -> list[Floats]:
    """Cut into rows no longer than cv2.remap takes."""
    return [values[k : k + 32_000] for k in range(0, len(values), 32_000)]
