"""The error map against brute force over OpenCV, and against cases known in closed form."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import calibrate, error_map
from simtip.errors import InputError
from simtip.geometry import Pose

LOW, HIGH = (-25, -20, 150), (25, 20, 190)
TRUE = paper_rig()


@pytest.fixture(scope="module")
def imperfect():
    points = grid(6, 5, 10.0)
    views = sightings(TRUE, points, board_poses(TRUE, points, 8), noise_px=0.3, seed=6)
    return calibrate(views, points, SIZE, SIZE).rig


def opencv_pixels(rig, points):
    T_rl = rig.T_lr.inverse()
    return [
        cv2.projectPoints(points, cv2.Rodrigues(R)[0], t, c.K, np.array(c.distortion))[0]
        for c, R, t in ((rig.left, np.eye(3), np.zeros(3)), (rig.right, T_rl.R, T_rl.t))
    ]


def opencv_rays(rig, pixels):
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-14)
    return [
        cv2.undistortPoints(uv, c.K, np.array(c.distortion), criteria=criteria).reshape(-1, 2)
        for uv, c in zip(pixels, (rig.left, rig.right), strict=True)
    ]


def opencv_points(rig, pixels):
    """Triangulate by OpenCV's linear method."""
    left, right = opencv_rays(rig, pixels)
    T_rl = rig.T_lr.inverse()
    P_r = np.column_stack([T_rl.R, T_rl.t])
    homogeneous = cv2.triangulatePoints(np.eye(3, 4), P_r, left.T, right.T)
    return (homogeneous[:3] / homogeneous[3]).T


def nearest_points(rig, pixels):
    """The points nearest to both rays: least squares of the distances from two lines."""
    left, right = opencv_rays(rig, pixels)
    A, b = np.zeros((len(left), 3, 3)), np.zeros((len(left), 3))
    for xy, pose in ((left, Pose.identity()), (right, rig.T_lr)):
        d = np.column_stack([xy, np.ones(len(xy))]) @ pose.R.T
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        off = np.eye(3) - d[:, :, None] * d[:, None, :]
        A, b = A + off, b + off @ pose.t
    return np.linalg.solve(A, b[:, :, None])[:, :, 0]


def test_it_is_what_one_measures_with_the_wrong_rig(imperfect):
    found = error_map(TRUE, imperfect, LOW, HIGH, (5, 4, 3), method="midpoint")
    assert len(found.points_mm) == 60
    brute = nearest_points(imperfect, opencv_pixels(TRUE, found.points_mm)) - found.points_mm
    size = np.linalg.norm(brute, axis=1)
    assert size.mean() > 0.05
    assert np.abs(found.displacement_mm - brute).max() < 1e-7
    summary = found.summary()
    assert summary["mean"] == pytest.approx(size.mean())
    assert summary["max"] == pytest.approx(size.max())
    for k, axis in enumerate(np.eye(3)):
        ends = [
            nearest_points(imperfect, opencv_pixels(TRUE, found.points_mm + s * axis))
            for s in (1, -1)
        ]
        error = np.linalg.norm(ends[0] - ends[1], axis=1) - 2
        assert np.abs(error).max() > 1e-4
        assert np.abs(found.step_error_mm[:, k] - error).max() < 1e-7
        of_step = summary["step"]["xyz"[k]]
        assert of_step["max_percent"] == pytest.approx(100 * np.abs(error).max() / 2)


def test_opencvs_triangulation_says_nearly_the_same(imperfect):
    # where the wrong rig's rays miss each other, each method has a point of its own
    found = error_map(TRUE, imperfect, LOW, HIGH, (5, 4, 3), method="optimal")
    theirs = opencv_points(imperfect, opencv_pixels(TRUE, found.points_mm)) - found.points_mm
    size = np.linalg.norm(theirs, axis=1)
    assert np.abs(found.displacement_mm - theirs).max() < 5e-3 * size.max()


def test_the_methods_of_triangulation_differ_by_less_than_the_error(imperfect):
    maps = [
        error_map(TRUE, imperfect, LOW, HIGH, (3, 3, 3), method=method)
        for method in ("svd", "midpoint", "optimal")
    ]
    means = [m.summary()["mean"] for m in maps]
    assert np.ptp(means) < 0.1 * np.mean(means)


def test_the_true_rig_makes_no_error():
    summary = error_map(TRUE, TRUE, LOW, HIGH).summary()
    assert summary["points"] == 729
    assert summary["max"] < 1e-8
    assert summary["step"]["z"]["max"] < 1e-8


def test_a_wrong_scale_is_its_share_of_everything():
    # squares 1 % too large: the baseline is, and so is all that is measured
    large = replace(TRUE, T_lr=Pose(TRUE.T_lr.R, 1.01 * TRUE.T_lr.t))
    found = error_map(TRUE, large, LOW, HIGH, (3, 3, 3))
    assert np.allclose(found.displacement_mm, 0.01 * found.points_mm, atol=1e-6)
    assert np.allclose(found.step_percent, 1.0, atol=1e-5)
    assert found.summary()["step"]["x"]["bias"] == pytest.approx(0.02, abs=1e-6)
    centred = found.points_mm - found.points_mm.mean(axis=0)
    assert np.allclose(found.deformation_mm, 0.01 * centred, atol=1e-6)


def test_a_shift_of_the_whole_frame_is_told_from_a_deformation(imperfect):
    found = error_map(TRUE, imperfect, LOW, HIGH, (5, 5, 5))
    moved = found.rigid.apply(found.points_mm) + found.deformation_mm
    assert np.allclose(moved, found.points_mm + found.displacement_mm, atol=1e-9)
    summary = found.summary()
    assert summary["deformation"]["mean"] < 0.5 * summary["mean"]
    # no other rigid transform leaves less
    best = (found.deformation_mm**2).sum()
    rng = np.random.default_rng(0)
    for _ in range(20):
        nudge = Pose(
            Rotation.from_rotvec(1e-4 * rng.standard_normal(3)).as_matrix(),
            0.01 * rng.standard_normal(3),
        )
        other = nudge @ found.rigid
        left = found.points_mm + found.displacement_mm - other.apply(found.points_mm)
        assert (left**2).sum() > best


def test_what_is_outside_either_image_is_left_out_and_counted(imperfect):
    found = error_map(TRUE, imperfect, (-150, -20, 150), (150, 20, 190), (31, 3, 3))
    assert len(found.points_mm) + found.left_out + found.failed == 31 * 9
    assert found.left_out > 0
    left, right = TRUE.project(found.points_mm)
    assert TRUE.left.contains(left).all()
    assert TRUE.right.contains(right).all()
    ends = found.points_mm + np.array([1.0, 0, 0])
    assert TRUE.left.contains(TRUE.project(ends)[0]).all()


def test_a_volume_that_nobody_sees_is_refused(imperfect):
    with pytest.raises(InputError, match="0 of the working volume's 729 points"):
        error_map(TRUE, imperfect, (-20, -20, -190), (20, 20, -150))
    with pytest.raises(InputError, match="low <= high"):
        error_map(TRUE, imperfect, HIGH, LOW)
    with pytest.raises(InputError, match="no length"):
        error_map(TRUE, imperfect, LOW, HIGH, step_mm=0)


def test_the_summary_is_json(imperfect):
    summary = error_map(TRUE, imperfect, LOW, HIGH, (3, 3, 3)).summary()
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
