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
    data = with_roi(scene, ROI, ROI, samples=SAMPLES).model_dump(mode="json")
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
        from simtip.render.world import load_world

        spec = with_roi(scene, ROI, ROI)
        yield load_world(spec), spec.rig.rig().left


def flat_light(world):
    """Light maps without noise, but with slopes so that lens samples differ."""
    from simtip.render.lightmap import Grid, LightMap, Lookup

    grid = Grid(-world.board.half, 10.0, 81, 81)
    ramp = (20 + grid.points() @ [0.01, 0.02]).reshape(81, 81, 1)
    level = LightMap(grid, np.repeat(ramp, len(world.tubes) + 1, axis=2).astype(np.float32))
    return Lookup(world.board, level, level)


def through_pixels(world, camera: Camera, pixels: np.ndarray, seed: int) -> np.ndarray:
    from simtip.render.eye import Eye
    from simtip.render.wavefront import render_pixels

    eye = Eye(camera, Pose.identity())
    light = flat_light(world)
    found, _ = render_pixels(world, light, eye, pixels, SAMPLES, seed, lambda _: None)
    return found[:, 0, 1]


def through_open_pixels(world, camera: Camera, pixels: np.ndarray, seed: int) -> np.ndarray:
    from simtip.render.eye import Eye
    from simtip.render.wavefront import render_open

    eye = Eye(camera, Pose.identity(), ThinLens(40.0, 170.0))
    found = render_open(flat_light(world), eye, pixels, SAMPLES, seed, lambda _: None)
    return found[:, 0]


def from_the_board(world, camera: Camera, pixels: np.ndarray, seed: int) -> np.ndarray:
    from simtip.render.lightmap import Illuminator
    from simtip.render.progress import Tally

    v, u = np.divmod(pixels, camera.width)
    st = world.board.meet(np.zeros(3), camera.rays(np.stack([u, v], axis=1)))
    light = Illuminator(world.scene, world.tubes, world.board)
    found, _ = light.trace(st, SAMPLES, seed, Tally(None))
    return found[:, 0]


WORK = (through_pixels, through_open_pixels, from_the_board)


@pytest.mark.parametrize("work", WORK, ids=lambda w: w.__name__)
def test_pieces_of_work_share_no_samples(stage, monkeypatch, work):
    from simtip.render import chunks

    world, camera = stage
    every = np.arange(camera.width * camera.height, dtype=np.uint32)
    # The same pixels three times over, each time in a launch of its own.
    monkeypatch.setattr(chunks, "LAUNCH_SAMPLES", len(every) * SAMPLES)
    one, two = (work(world, camera, np.tile(every, 3), seed) for seed in (1, 2))
    first, second, third = relative_noise(one, two).reshape(3, -1)
    assert_independent(first, second)
    assert_independent(second, third)
    assert_independent(first, third)
