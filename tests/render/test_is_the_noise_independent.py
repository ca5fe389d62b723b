"""Is the renderer's noise another one for each camera, each piece of work and each seed?

The difference of two renders that differ only in their seed is noise alone: the picture drops out.
Wherever two places should have noise of their own, their differences must be uncorrelated.
"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.lens import ThinLens
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

ROI = [803, 690, 36, 60]
"""The shaft, seen by the left camera."""
SAMPLES = 16


NOISY = 1e-5
"""Smaller relative differences are rounding."""


def relative_noise(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    return (values.astype(float) - others) / np.maximum(np.abs(values), np.abs(others)).max()


def assert_independent(a: np.ndarray, b: np.ndarray) -> None:
    """Differences of independent noise agree in sign half the time, however large each is."""
    noisy = (np.abs(a) > NOISY) & (np.abs(b) > NOISY)
    assert noisy.sum() > 500
    together = np.mean(np.sign(a[noisy]) * np.sign(b[noisy]))
    assert abs(together) < 5 / np.sqrt(noisy.sum())


def twin_cameras(scene: SceneSpec) -> SceneSpec:
    """Two cameras that see the same picture: with equal seeds they would have equal noise."""
    data = with_roi(scene, ROI, ROI, samples=SAMPLES, noise=None).model_dump(mode="json")
    data["rig"]["right"] = data["rig"]["left"]
    data["rig"]["R"] = np.eye(3).tolist()
    data["rig"]["t_mm"] = [1e-6, 0, 0]
    return SceneSpec.model_validate(data)


def test_two_cameras_share_no_samples(scene):
    spec = twin_cameras(scene)
    first, other = (render_pair(spec, seed=seed) for seed in (1, 2))
    inside = (first[0].coverage == 1) & (first[1].coverage == 1)
    assert inside.sum() > 900
    np.testing.assert_allclose(first[0].depth_mm, first[1].depth_mm, rtol=1e-6)
    for lamp in range(len(spec.lamps)):
        left, right = (
            relative_noise(a.response[lamp, inside, 1], b.response[lamp, inside, 1])
            for a, b in zip(first, other, strict=True)
        )
        assert_independent(left, right)


@pytest.fixture(scope="module")
def stage(scene):
    """The active back end, the loaded world and the left camera, cut down."""
    with activated(choose()):
        from simtip.render.needle_subject import NeedleSubject
        from simtip.render.world import load_world

        spec = with_roi(scene, ROI, ROI)
        yield load_world(spec, 1, NeedleSubject(spec)), spec.rig.rig().left


def sloping_backdrop(world):
    """A background without noise, but with slopes so that lens samples differ."""
    from simtip.render.backdrop import Backdrop
    from simtip.render.lightmap import Grid, LightMap

    grid = Grid(-world.board.half, 10.0, 81, 81)
    ramp = (20 + grid.points() @ [0.01, 0.02]).reshape(81, 81, 1)
    values = np.repeat(ramp, len(world.lamps) + 1, axis=2).astype(np.float32)
    level = LightMap(grid, values, *2 * [np.zeros_like(values)])
    return Backdrop(world.board, np.ones(3), (level, level))


def through_pixels(world, camera: Camera, seed: int) -> np.ndarray:
    from simtip.render.estimate import Goal
    from simtip.render.eye import Eye
    from simtip.render.progress import Tally
    from simtip.render.wavefront import render_pixels

    goal = Goal(SAMPLES, np.ones((len(world.lamps) + 1, 3), np.float32))
    found = render_pixels(
        world,
        sloping_backdrop(world),
        Eye(camera, Pose.identity()),
        np.arange(camera.width * camera.height, dtype=np.uint32),
        goal,
        seed,
        Tally(None),
        0.0,
    )
    return found.response[:, 0, 1]


def through_open_pixels(world, camera: Camera, seed: int) -> np.ndarray:
    from simtip.render.eye import Eye
    from simtip.render.progress import Tally
    from simtip.render.wavefront import render_open

    eye = Eye(camera, Pose.identity(), ThinLens(40.0, 170.0))
    pixels = np.arange(camera.width * camera.height, dtype=np.uint32)
    found, _, _ = render_open(sloping_backdrop(world), eye, pixels, SAMPLES, seed, Tally(None))
    return found[:, 0]


def from_the_board(world, camera: Camera, seed: int) -> np.ndarray:
    from simtip.render.illuminator import Illuminator
    from simtip.render.progress import Tally

    v, u = np.divmod(np.arange(camera.width * camera.height), camera.width)
    st = world.board.meet(np.zeros(3), camera.rays(np.stack([u, v], axis=1)))
    light = Illuminator(world.scene, world.lamps, world.surround, world.board, 50.0)
    found, _ = light.lamps(st, SAMPLES, seed, Tally(None))
    return found[:, 0]


WORK = (through_pixels, through_open_pixels, from_the_board)


@pytest.mark.parametrize("work", WORK, ids=lambda w: w.__name__)
def test_neighbours_share_no_samples(stage, work):
    world, camera = stage
    one, two = (work(world, camera, seed) for seed in (1, 2))
    noise = relative_noise(one, two).reshape(camera.height, camera.width)
    assert_independent(noise[:, :-1], noise[:, 1:])
    assert_independent(noise[:-1], noise[1:])


@pytest.mark.parametrize("work", WORK, ids=lambda w: w.__name__)
def test_how_work_is_cut_into_pieces_changes_nothing(stage, monkeypatch, work):
    from simtip.render import chunks

    world, camera = stage
    whole = work(world, camera, 1)
    monkeypatch.setattr(chunks, "LAUNCH_SAMPLES", 307 * SAMPLES)
    np.testing.assert_array_equal(work(world, camera, 1), whole)
