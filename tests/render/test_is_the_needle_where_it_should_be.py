"""Does the rendered needle have the shape and the place of the real one?"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi
from scipy.spatial import ConvexHull

from simtip.geometry import Pose
from simtip.render import render_pair
from simtip.spec import SceneSpec

ROIS = ([760, 700, 120, 200], [970, 700, 120, 200])


def variants(scene: SceneSpec) -> dict[str, SceneSpec]:
    """Short needles that lie wholly in the crop, so that their area can be known."""
    small = with_roi(scene, *ROIS, samples=256).model_dump(mode="json")
    needles = {
        "cone": {"tip": {"kind": "cone", "length_mm": 5}},
        "bevel": {"tip": {"kind": "bevel", "angle_deg": 20}, "roll_deg": 40},
        "tilted": {"tip": {"kind": "cone", "length_mm": 3}, "axis": [0.2, -1, 0.3]},
    }
    return {
        name: SceneSpec.model_validate(
            {**small, "needle": {**small["needle"], "length_mm": 12, **needle}}
        )
        for name, needle in needles.items()
    }


@pytest.fixture(
    scope="module",
    params=["bevel", *(pytest.param(k, marks=pytest.mark.slow) for k in ("cone", "tilted"))],
)
def rendered(request, scene):
    spec = variants(scene)[request.param]
    return spec, render_pair(spec)


def silhouette(spec: SceneSpec, side: int) -> tuple[float, np.ndarray]:
    """Area (px^2) and centroid (px) of the projected needle: the hull of its projected vertices."""
    rig = spec.rig.rig()
    camera, T_cw = [(rig.left, Pose.identity()), (rig.right, rig.T_lr.inverse())][side]
    vertices = (T_cw @ spec.needle.pose()).apply(spec.needle.needle().mesh().vertices)
    corners = camera.project(vertices)
    corners = corners[ConvexHull(corners).vertices]
    assert camera.contains(corners).all()
    x, y = corners.T
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y1 - x1 * y
    area = cross.sum() / 2
    centroid = np.array([((x + x1) * cross).sum(), ((y + y1) * cross).sum()]) / (6 * area)
    return abs(area), centroid


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_the_needle_covers_its_projected_area(rendered, side):
    spec, views = rendered
    area, _ = silhouette(spec, side)
    # About 300 edge pixels, each with a standard error of under 0.02 at 256 stratified samples.
    assert views[side].coverage.sum() == pytest.approx(area, abs=1.0)


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_the_needles_centroid_is_projected_to_where_it_is_seen(rendered, side):
    spec, views = rendered
    _, centroid = silhouette(spec, side)
    coverage = views[side].coverage
    v, u = np.mgrid[: coverage.shape[0], : coverage.shape[1]]
    seen = np.array([(u * coverage).sum(), (v * coverage).sum()]) / coverage.sum()
    np.testing.assert_array_less(np.abs(seen - centroid), [0.005, 0.03])


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_depth_is_the_surfaces_z_in_the_cameras_own_frame(rendered, side):
    spec, views = rendered
    rig = spec.rig.rig()
    camera, T_cw = [(rig.left, Pose.identity()), (rig.right, rig.T_lr.inverse())][side]
    depth = views[side].depth_mm
    # The background is the plane z = 260 of the left frame.
    v, u = np.nonzero(views[side].coverage == 0)
    rays = T_cw.inverse().rotate(camera.rays(np.stack([u, v], axis=-1)))
    centre = T_cw.inverse().t
    points = centre + rays * ((260 - centre[2]) / rays[:, 2])[:, None]
    np.testing.assert_allclose(depth[v, u], T_cw.apply(points)[:, 2], rtol=1e-5)
    # On the needle the surface lies within a radius of the axis, on the near side of it.
    T_nc = spec.needle.pose().inverse() @ T_cw.inverse()
    v, u = np.nonzero(views[side].coverage > 0.99)
    rays = camera.rays(np.stack([u, v], axis=-1))
    surface = T_nc.apply(rays / rays[:, 2:] * depth[v, u][:, None])
    radius = np.hypot(surface[:, 0], surface[:, 1])
    shaft = (surface[:, 2] > 6) & (surface[:, 2] < 11)
    assert shaft.sum() > 200
    np.testing.assert_allclose(radius[shaft], 1.67 / 2, atol=1e-3)
