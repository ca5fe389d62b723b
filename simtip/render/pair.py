"""Both views of a scene on a vectorised back end.

Pixels that show only the background's smooth light read it from the light map; all that the needle
may touch, all clutter, and all near a lamp or the background's edge, are sampled one by one until
their noise is as small as asked. A lamp thinner than a pixel may be missed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.clutter import ClutterObject, board_texture, grouped, objects
from simtip.geometry import Array, Pose
from simtip.mix import steady_weights
from simtip.render.backdrop import Backdrop
from simtip.render.backend import Backend
from simtip.render.canvas import Canvas
from simtip.render.estimate import Goal
from simtip.render.lighting import Lighting
from simtip.render.look import Look, look_through
from simtip.render.needle_subject import NeedleSubject
from simtip.render.progress import Tally
from simtip.render.setting import clutter_setting
from simtip.render.subject import Subject
from simtip.render.view import Floats, Progress, Tolerance, View
from simtip.render.world import World, load_world
from simtip.spec import SceneSpec

USUAL_SAMPLES = 500
"""That a pixel takes: a guess, for the progress bar."""


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene loaded and lit, and what each camera will have to look at.

    Attributes
    ----------
    world
        The loaded scene.
    looks
        Left and right.
    backdrop
        The background with its light.
    """

    world: World
    looks: tuple[Look, Look]
    backdrop: Backdrop


def render_views(
    spec: SceneSpec,
    backend: Backend,
    seed: int,
    tolerance: Tolerance | None,
    progress: Progress | None,
    subject: Subject | None = None,
) -> tuple[View, View]:
    """Render left and right; see `simtip.render.render_pair`."""
    tally = Tally(progress)
    stage = set_stage(spec, seed, tolerance, tally, subject or NeedleSubject(spec))
    return paint(spec, stage, backend, seed, tolerance, tally)


def set_stage(
    spec: SceneSpec, seed: int, tolerance: Tolerance | None, tally: Tally, subject: Subject
) -> Stage:
    """Load a scene with a subject before its cameras, and work out the light on its background."""
    rig = spec.rig.rig()
    clutter = solid_clutter(spec, seed)
    world = load_world(spec, seed, subject, clutter)
    lenses = spec.rig.left.lens.thin_lens(), spec.rig.right.lens.thin_lens()
    left = look_through(spec, world, "left", rig.left, Pose.identity(), lenses[0], clutter)
    right = look_through(spec, world, "right", rig.right, rig.T_lr, lenses[1], clutter)
    for look in (left, right):
        tally.plan(look.open_samples * int((~look.full).sum()))
        tally.expect(min(spec.render.samples, USUAL_SAMPLES) * int(look.full.sum()))
    low, high = _seen_box(spec, world, [left, right])
    lighting = Lighting(spec, world, seed, tally, tolerance)
    world.subject.light(lighting)
    backdrop = Backdrop(
        world.board,
        np.array(spec.background.albedo),
        lighting.on_background(low, high),
        board_texture(spec.background, spec.clutter, seed, low, high),
        tuple(np.array(lamp.centre_mm) for lamp in spec.lamps),
    )
    return Stage(world, (left, right), backdrop)


def paint(
    spec: SceneSpec,
    stage: Stage,
    backend: Backend,
    seed: int,
    tolerance: Tolerance | None,
    tally: Tally,
) -> tuple[View, View]:
    """Look at what is on a stage, left and right."""
    world, backdrop = stage.world, stage.backdrop
    canvases = [Canvas(look, world, backdrop, seed, tally) for look in stage.looks]
    goal = _goal(spec, canvases, tolerance)
    for canvas in canvases:
        canvas.refine_open(backdrop, goal, tally)
    left_view, right_view = (
        canvas.finished(world, backdrop, goal, backend, tally) for canvas in canvases
    )
    tally.finish()
    return left_view, right_view


def solid_clutter(spec: SceneSpec, seed: int) -> tuple[ClutterObject, ...]:
    """Give a scene's solid clutter as meshes, those of one look joined."""
    return grouped(objects(spec.clutter, clutter_setting(spec), seed))


def _seen_box(spec: SceneSpec, world: World, looks: list[Look]) -> tuple[Array, Array]:
    """Give the box (low, high) of the board that holds all of it that is in view, or in a crop."""
    half = world.board.half
    ends = [
        [column.min(), column.max()]
        for look in looks
        if (near := look.near_background()).any()
        for column in (look.hits.board_st[:, axis][near] for axis in (0, 1))
    ]
    boxes = np.array(ends or [[0.0, 0.0]] * 2, np.float64).reshape(-1, 2, 2)  # look, axis, end
    margin = 3 * spec.render.light_step_mm
    return (
        np.maximum(boxes[:, :, 0].min(axis=0) - margin, -half),
        np.minimum(boxes[:, :, 1].max(axis=0) + margin, half),
    )


def _goal(spec: SceneSpec, canvases: list[Canvas], tolerance: Tolerance | None) -> Goal:
    """Turn what is asked for into numbers: the mix that is judged, and how far it may be off."""
    mean = steady_weights(spec).astype(np.float32)
    if tolerance is None or spec.render.noise is None:
        return Goal(spec.render.samples, mean)
    levels = [canvas.background(mean) for canvas in canvases]
    known = [level for level in levels if level is not None]
    background = np.mean(known, axis=0) if known else None
    allowed = tolerance

    def permitted(radiance: Floats) -> Floats:
        return allowed(radiance, background)

    return Goal(spec.render.samples, mean, permitted)
