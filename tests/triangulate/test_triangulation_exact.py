"""Does every method give back a point from its exact images?"""

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose
from simtip.triangulate import METHODS, triangulate, triangulate_points


@st.composite
def cameras(draw):
    fx, fy = (draw(st.floats(500, 4000)) for _ in range(2))
    cx, cy = draw(st.floats(300, 1700)), draw(st.floats(200, 1200))
    return Camera(np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), 2048, 1436)


@st.composite
def rigs_with_points(draw):
    """Give a rig with its cameras turned by up to 40 degrees, and a point in front of both."""
    # Rounded: nobody measures a rig to 1e-143 mm.
    turn = [round(draw(st.floats(-0.7, 0.7)), 9) for _ in range(3)]
    aside = draw(st.floats(20, 200)) * draw(st.sampled_from([-1, 1]))
    t = np.round([aside, draw(st.floats(-100, 100)), draw(st.floats(-60, 60))], 9)
    rig = StereoRig(
        draw(cameras()), draw(cameras()), Pose(Rotation.from_rotvec(turn).as_matrix(), t)
    )
    z = draw(st.floats(80, 500))
    point = np.array([draw(st.floats(-0.6, 0.6)) * z, draw(st.floats(-0.6, 0.6)) * z, z])
    in_right = rig.T_lr.inverse().apply(point)
    assume(in_right[2] > 40)
    assume(np.abs(in_right[:2]).max() < 1.5 * in_right[2])
    # rays at least 1 degree from each other and from the baseline
    rays = np.stack([point, point - t, t])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    assume(min(np.linalg.norm(np.cross(rays[i], rays[i - 1])) for i in range(3)) > 0.0175)
    return rig, point


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


def test_points_in_front_of_the_papers_rig_are_recovered(table_1, volume_mm, method):
    left, right = table_1.project(volume_mm)
    points = triangulate_points(left, right, table_1, method)
    assert np.abs(points - volume_mm).max() < 1e-9


@settings(derandomize=True, deadline=None, max_examples=60)
@given(case=rigs_with_points(), method=st.sampled_from(METHODS))
def test_a_point_in_front_of_any_rig_is_recovered(case, method):
    rig, point = case
    estimate = triangulate(*rig.project(point), rig, method)
    assert estimate.ok, estimate.reason
    assert np.abs(estimate.point_mm - point).max() < 1e-9
    assert estimate.gap_mm < 1e-9
    assert np.abs(estimate.reprojection_px).max() < 1e-8
    assert estimate.depths_mm == pytest.approx(
        [point[2], rig.T_lr.inverse().apply(point)[2]], abs=1e-9
    )


def test_a_nearly_rectified_rig_costs_no_accuracy(method):
    """Its epipoles are far out, 40,000 px, which spreads the roots of the optimal method."""
    camera = Camera(np.array([[500.0, 0, 300], [0, 500, 200], [0, 0, 1]]), 600, 400)
    rolled = Rotation.from_rotvec([0, 0, 0.375]).as_matrix()
    rig = StereoRig(camera, camera, Pose(rolled, np.array([-20.0, 0, 0.25])))
    point = np.array([0.0, 0.0, 80.0])
    assert np.abs(triangulate(*rig.project(point), rig, method).point_mm - point).max() < 1e-9


def test_distortion_is_undone(distorted, volume_mm, method):
    """To 1e-5 mm: undoing distortion is an iteration, good to about 1e-5 px at the corners."""
    left, right = distorted.project(volume_mm)
    points = triangulate_points(left, right, distorted, method)
    assert np.abs(points - volume_mm).max() < 1e-5
    estimate = triangulate(left[0], right[0], distorted, method)
    assert np.abs(estimate.reprojection_px).max() < 1e-4


def test_exact_pairs_agree_with_opencv(table_1, volume_mm, method):
    left, right = table_1.project(volume_mm)
    inverse = table_1.T_lr.inverse()
    P_left = table_1.left.K @ np.eye(3, 4)
    P_right = table_1.right.K @ np.column_stack([inverse.R, inverse.t])
    homogeneous = cv2.triangulatePoints(P_left, P_right, left.T, right.T)
    theirs = (homogeneous[:3] / homogeneous[3]).T
    assert np.abs(theirs - volume_mm).max() < 1e-6
    assert np.abs(triangulate_points(left, right, table_1, method) - theirs).max() < 1e-6


def test_one_pair_is_the_same_as_one_of_many(table_1, volume_mm, method):
    rng = np.random.default_rng(5)
    left, right = (p + rng.normal(0, 1, p.shape) for p in table_1.project(volume_mm[:6]))
    many = triangulate_points(left.reshape(2, 3, 2), right.reshape(2, 3, 2), table_1, method)
    assert many.shape == (2, 3, 3)
    for i, point in enumerate(many.reshape(6, 3)):
        single = triangulate(left[i], right[i], table_1, method)
        assert single.point_mm == pytest.approx(point, abs=1e-12)


@pytest.mark.parametrize("tz", [0.0, 1.9e-143, 1e-30])
@pytest.mark.filterwarnings("error")
def test_a_next_to_rectified_rig_gives_no_warning(method, tz):
    camera = Camera(np.array([[500.0, 0, 300], [0, 500, 200], [0, 0, 1]]), 2048, 1436)
    other = Camera(np.array([[500.0, 0, 300], [0, 500, 201], [0, 0, 1]]), 2048, 1436)
    turn = Rotation.from_rotvec([0, 0, -5.96046448e-08]).as_matrix()
    rig = StereoRig(camera, other, Pose(turn, np.array([-20.0, 0, tz])))
    estimate = triangulate(*rig.project([0.0, 0.0, 83.0]), rig, method)
    assert np.abs(estimate.point_mm - [0, 0, 83]).max() < 1e-9
