"""Is the plate's mesh, with its normals and outline, the bowed and wrongly printed plate stated?"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.plate import Plate
from simtip.target import parse_target

COUNT = settings(derandomize=True, deadline=None, max_examples=30)
SCALES = st.floats(0.8, 1.25)

plates = st.builds(
    Plate,
    st.sampled_from(
        ["chessboard:11x8:6", "charuco:5x7:4:3", "circles:4x9:2:1", "asymmetric:4x11:6:3"]
    ).map(parse_target),
    margin_mm=st.floats(0.5, 10),
    thickness_mm=st.floats(0.1, 10),
    bow_mm=st.floats(-3, 3) | st.just(0.0),
    print_scale=st.tuples(SCALES, SCALES),
)
places = st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=20)


def on(plate: Plate, fractions: list) -> np.ndarray:
    return plate.low + np.array(fractions) * (plate.high - plate.low)


@COUNT
@given(plates)
def test_its_size_is_the_scaled_print_and_the_margin(plate):
    scale = np.array(plate.print_scale)
    size = (plate.target.high - plate.target.low) * scale + 2 * plate.margin_mm
    np.testing.assert_allclose(plate.high - plate.low, size)
    # Stretched about the first point, which stays.
    np.testing.assert_allclose(plate.points[0, :2], plate.target.points[0, :2] * scale, atol=1e-12)
    np.testing.assert_allclose(plate.low, plate.target.low * scale - plate.margin_mm)


@COUNT
@given(plates)
def test_the_bow_is_how_far_corners_stand_off_the_middle(plate):
    corners = [[plate.low[0], plate.low[1]], [plate.high[0], plate.low[1]], plate.high]
    np.testing.assert_allclose(plate.height(corners), plate.bow_mm, atol=1e-12)
    assert plate.surface(plate.middle[None, :2])[0, 2] == 0
    np.testing.assert_array_equal(
        plate.points, plate.surface(plate.target.points[:, :2] * plate.print_scale)
    )


@COUNT
@given(plates, places)
def test_normals_are_those_of_finite_differences(plate, fractions):
    at, h = on(plate, fractions), 1e-4
    across, down = (
        (plate.surface(at + step) - plate.surface(at - step)) / (2 * h) for step in h * np.eye(2)
    )
    expected = np.cross(down, across)  # towards the viewer: -z
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert (expected[:, 2] < 0).all()
    np.testing.assert_allclose(plate.normals(at), expected, atol=1e-8)


@COUNT
@given(plates)
def test_the_mesh_lies_on_the_surface_and_faces_the_viewer(plate):
    vertices, faces = plate.front()
    np.testing.assert_allclose(vertices, plate.surface(vertices[:, :2]), atol=1e-12)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert (mesh.face_normals[:, 2] < 0).all()
    # Facets between: nowhere more than half a micrometre off, 0.005 px at the paper's distance.
    middles = vertices[faces].mean(axis=1)
    assert np.abs(middles[:, 2] - plate.height(middles[:, :2])).max() < 5e-4
    size = plate.high - plate.low
    flat = trimesh.Trimesh(vertices * [1, 1, 0], faces, process=False)
    assert flat.area == pytest.approx(size.prod())
    np.testing.assert_allclose(flat.bounds[:, :2], [plate.low, plate.high])


@COUNT
@given(plates)
def test_the_outline_runs_around_it(plate):
    rim = plate.outline()
    np.testing.assert_allclose(rim[:, 2], plate.height(rim[:, :2]), atol=1e-12)
    on_side = (np.abs(rim[:, :2] - plate.low) < 1e-9) | (np.abs(rim[:, :2] - plate.high) < 1e-9)
    assert on_side.any(axis=1).all()
    assert on_side.all(axis=1).sum() == 4
    x, y = rim[:, 0], rim[:, 1]
    area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    assert area == pytest.approx((plate.high - plate.low).prod())


@COUNT
@given(plates)
def test_front_and_body_close_around_the_plate(plate):
    vertices, faces = plate.body()
    body = trimesh.Trimesh(vertices, faces, process=False)
    behind = vertices[:, 2] - plate.height(vertices[:, :2])
    np.testing.assert_allclose(behind.min(), 0, atol=1e-12)
    np.testing.assert_allclose(behind.max(), plate.thickness_mm)
    # With a lid from the rim to the middle it holds as much as its area is thick.
    count, middle = len(plate.outline()), len(vertices)
    k = np.arange(count)
    lid = np.stack([(k + 1) % count, k, np.full(count, middle)], axis=1)
    closed = trimesh.Trimesh(
        np.vstack([vertices, plate.surface(plate.middle[None, :2])]),
        np.vstack([faces, lid]),
        process=False,
    )
    assert body.face_normals.shape[0] == 3 * count
    assert closed.is_watertight
    assert closed.is_winding_consistent
    area = (plate.high - plate.low).prod()
    assert abs(closed.volume) == pytest.approx(area * plate.thickness_mm)
