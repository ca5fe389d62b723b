"""Depth and masks by single rays: those of a full render, and what stands before what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from regions import with_roi

from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.render import Backend, choose, render_pair, trace_surfaces
from simtip.spec import SceneSpec

LEFT, RIGHT = [740, 560, 140, 360], [950, 560, 160, 360]


@pytest.fixture(scope="module")
def cluttered(scene) -> SceneSpec:
    """A scene with a cable before the needle."""
    small = with_roi(scene, LEFT, RIGHT, noise=None, samples=16, light_step_mm=8.0)
    data = small.model_dump(mode="json")
    return SceneSpec.model_validate(
        {**data, "seed": 2, "clutter": {"level": "hostile", "occlude": True}}
    )


@pytest.mark.slow
def test_depth_is_the_renders_bit_for_bit_and_the_mask_its_coverage(cluttered):
    backend = choose("llvm")
    traced = trace_surfaces(cluttered, backend=backend)
    rendered = render_pair(cluttered, backend=backend)
    for surfaces, view in zip(traced, rendered, strict=True):
        assert np.array_equal(surfaces.depth_mm, view.depth_mm)
        differ = surfaces.needle != (view.coverage > 0.5)
        assert differ.sum() < 0.04 * surfaces.needle.sum()
        assert ((view.coverage[differ] > 0) & (view.coverage[differ] < 1)).mean() > 0.9
        assert not (surfaces.needle & ~surfaces.silhouette).any()
        hidden = surfaces.silhouette & ~surfaces.needle
        assert hidden.sum() > 300
        assert view.clutter[hidden].mean() > 0.8


def test_points_before_which_a_cable_hangs_are_obstructed(cluttered):
    """A point is seen where the depth at its pixel is not less than its own."""
    needle = cluttered.needle
    along = np.linspace(0.5, 16, 60)
    points = np.array(needle.tip_mm) + along[:, None] * np.array(needle.axis)
    rig = cluttered.rig.rig()
    traced = trace_surfaces(cluttered, backend=choose("llvm"), points_mm=points)
    poses = Pose.identity(), rig.T_lr.inverse()
    for surfaces, camera, T_cw in zip(traced, (rig.left, rig.right), poses, strict=True):
        seen = T_cw.apply(points)
        u, v = np.rint(camera.project(seen)).astype(int).T
        nearest = surfaces.depth_mm[v, u]
        # The needle's own front is up to a radius before its axis.
        assert (surfaces.obstructed == (nearest < seen[:, 2] - 1.5)).mean() > 0.93
        assert 0 < surfaces.obstructed.sum() < len(points)


def test_the_silhouette_goes_on_beyond_the_image_as_on_a_larger_sensor(scene):
    small = with_roi(scene, LEFT, RIGHT)
    wide = with_roi(scene, [600, 200, 420, 1080], [790, 200, 480, 1080])
    backend = choose("llvm")
    grown = trace_surfaces(small, backend=backend, beyond=1)
    whole = trace_surfaces(wide, backend=backend)
    for own, other in zip(grown, whole, strict=True):
        assert own.needle.shape == (360, own.silhouette.shape[1] // 3)
        assert np.array_equal(own.silhouette, other.silhouette)
        assert own.silhouette[:360].any()


def test_another_rig_of_the_same_places_may_look(scene):
    small = with_roi(scene, LEFT, RIGHT)
    rig = small.rig.rig()
    shifted = replace(rig, left=rig.left.cropped(10, 20, 100, 300))
    plain, _ = trace_surfaces(small, backend=choose("llvm"))
    cut, _ = trace_surfaces(small, backend=choose("llvm"), rig=shifted)
    assert np.array_equal(cut.needle, plain.needle[20:320, 10:110])
    assert np.array_equal(cut.depth_mm, plain.depth_mm[20:320, 10:110])


def test_the_scalar_back_end_is_refused(scene):
    with pytest.raises(InputError, match="traces no masks"):
        trace_surfaces(scene, backend=Backend("scalar", "asked for"))
