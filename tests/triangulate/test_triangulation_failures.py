"""Is a pair that has no point a reason, and never a coordinate?"""

import numpy as np
import pytest

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose
from simtip.triangulate import METHODS, triangulate, triangulate_points

CAMERA = Camera(np.array([[1000.0, 0, 500], [0, 1000, 400], [0, 0, 1]]), 1000, 800)
RECTIFIED = StereoRig(CAMERA, CAMERA, Pose(np.eye(3), np.array([60.0, 0, 0])))
FORWARD = StereoRig(CAMERA, CAMERA, Pose(np.eye(3), np.array([0.0, 0, 100])))


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


def refused(tip_left, tip_right, rig, method):
    estimate = triangulate(tip_left, tip_right, rig, method, sigma_px=0.1)
    assert not estimate.ok
    assert estimate.method == method
    for value in ("point_mm", "covariance_mm2", "gap_mm", "depths_mm", "reprojection_px"):
        assert getattr(estimate, value) is None
    return estimate


def test_parallel_rays_have_no_point(method):
    estimate = refused([520.0, 430.0], [520.0, 430.0], RECTIFIED, method)
    assert estimate.status == "rays_parallel"
    assert "angle" in estimate.reason


@pytest.mark.parametrize("lean", [0.0, 1e-11, 1e-8])
def test_rays_of_turned_cameras_are_parallel_up_to_rounding(table_1, method, lean):
    direction = np.array([-0.2, 0.05 + lean, 1.0])
    left = table_1.left.project(np.array([-0.2, 0.05, 1.0]))
    right = table_1.right.project(table_1.T_lr.inverse().rotate(direction))
    estimate = triangulate(left, right, table_1, method)
    assert (estimate.status == "rays_parallel") == (lean < 1e-9)


def test_rays_that_diverge_meet_behind_the_cameras(method):
    estimate = refused([500.0, 430.0], [520.0, 430.0], RECTIFIED, method)
    assert estimate.status == "behind_camera"
    assert "mm" in estimate.reason


def test_rays_that_diverge_and_miss_are_refused_too(method):
    assert refused([500.0, 430.0], [520.0, 434.0], RECTIFIED, method).status == "behind_camera"


@pytest.mark.parametrize(
    ("method", "left", "right"),
    [("svd", (34.0, 790.0), (35.0, 235.0)), ("midpoint", (997.0, 280.0), (967.0, 621.0))],
)
def test_a_point_in_front_made_of_rays_that_come_closest_behind_is_refused(method, left, right):
    rig = StereoRig(CAMERA, CAMERA, Pose(np.eye(3), np.array([60.0, 0, 20])))
    point = triangulate_points(left, right, rig, method)
    assert min(point[2], rig.T_lr.inverse().apply(point)[2]) > 0
    estimate = refused(left, right, rig, method)
    assert estimate.status == "behind_camera"
    assert "come closest behind" in estimate.reason


def test_a_point_between_a_forward_camera_and_the_rear_one_is_behind_the_former(method):
    # 60 mm in front of the left camera, 40 mm behind the right one
    point = np.array([6.0, 3.0, 60.0])
    left = CAMERA.project(point)
    behind = point - [0, 0, 100]
    right = behind[:2] / behind[2] * 1000 + [500, 400]
    assert refused(left, right, FORWARD, method).status == "behind_camera"


def test_a_ray_along_the_baseline_has_no_depth(method):
    for left, right in (([500, 400], [520, 410]), ([520, 410], [500, 400])):
        assert refused(left, right, FORWARD, method).status == "along_baseline"


def test_a_far_point_is_still_a_point(method):
    far = np.array([1000.0, -300.0, 1e5])
    estimate = triangulate(*RECTIFIED.project(far), RECTIFIED, method)
    assert estimate.ok, estimate.reason
    assert estimate.point_mm == pytest.approx(far, rel=1e-6)


def test_bad_arguments_are_errors():
    with pytest.raises(ValueError, match="two finite numbers"):
        triangulate([np.nan, 0], [0, 0], RECTIFIED)
    with pytest.raises(ValueError, match="two finite numbers"):
        triangulate([0, 0], [0, 0, 1], RECTIFIED)
    with pytest.raises(ValueError, match="svd, midpoint, optimal, not 'best'"):
        triangulate([0, 0], [0, 0], RECTIFIED, "best")
