"""Is each method's point the one its definition says, when the rays miss each other?"""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares, minimize_scalar

from simtip.camera import Camera, StereoRig
from simtip.correspondence import _nearest_feet, nearest_correspondence
from simtip.geometry import Pose
from simtip.triangulate import METHODS, triangulate, triangulate_points

NOISE_PX = 3.0


@pytest.fixture(scope="module")
def pairs(table_1, volume_mm):
    rng = np.random.default_rng(11)
    return [p + rng.normal(0, NOISE_PX, p.shape) for p in table_1.project(volume_mm[::18])]


def rays(left, right, rig):
    """Give unit directions in the rig frame; the right ray starts at T."""
    return rig.left.rays(left), rig.T_lr.rotate(rig.right.rays(right))


def test_svd_is_the_least_squares_solution_of_equation_22(table_1, pairs):
    K_left, K_right = table_1.left.K, table_1.right.K
    R, t = table_1.T_lr.R, table_1.T_lr.t
    for left, right in zip(*pairs, strict=True):
        x1, y1 = (left - K_left[:2, 2]) / np.diag(K_left)[:2]
        x2, y2 = (right - K_right[:2, 2]) / np.diag(K_right)[:2]
        A = np.array([[x1, t[0]], [y1, t[1]], [1, t[2]]])
        b = R[:, 0] * x2 + R[:, 1] * y2 + R[:, 2]
        (ratio, minus_inverse), *_ = np.linalg.lstsq(A, b)
        z1 = ratio / -minus_inverse
        expected = np.array([x1 * z1, y1 * z1, z1])
        assert triangulate(left, right, table_1, "svd").point_mm == pytest.approx(
            expected, abs=1e-9
        )


def test_svd_gives_a_point_on_the_left_ray(table_1, pairs):
    estimate = triangulate(pairs[0][0], pairs[1][0], table_1, "svd")
    assert estimate.reprojection_px[0] == pytest.approx([0, 0], abs=1e-9)
    assert np.abs(estimate.reprojection_px[1]).max() > 0.1


def test_midpoint_is_halfway_across_the_gap(table_1, pairs):
    for left, right in zip(*pairs, strict=True):
        d1, d2 = rays(left, right, table_1)
        t = table_1.T_lr.t
        best, *_ = np.linalg.lstsq(np.column_stack([d1, -d2]), t)
        p, q = best[0] * d1, t + best[1] * d2
        estimate = triangulate(left, right, table_1, "midpoint")
        assert estimate.point_mm == pytest.approx((p + q) / 2, abs=1e-9)
        assert estimate.gap_mm == pytest.approx(np.linalg.norm(p - q), abs=1e-9)


def cost(point, left, right, rig):
    seen = rig.project(point)
    return np.concatenate([seen[0] - left, seen[1] - right])


def test_optimal_has_the_least_reprojection_error_in_space(table_1, pairs):
    for left, right in zip(*pairs, strict=True):
        start = triangulate(left, right, table_1, "midpoint").point_mm
        best = least_squares(
            cost, start, args=(left, right, table_1), xtol=1e-15, ftol=1e-15, gtol=1e-12
        )
        estimate = triangulate(left, right, table_1, "optimal")
        assert estimate.point_mm == pytest.approx(best.x, abs=1e-5)
        ours = np.sum(estimate.reprojection_px**2)
        assert ours <= 2 * best.cost * (1 + 1e-9)
        assert ours < np.sum(triangulate(left, right, table_1, "svd").reprojection_px ** 2)


def test_optimal_agrees_with_opencvs_corrected_matches(table_1, pairs):
    left, right = pairs
    corrected = cv2.correctMatches(table_1.fundamental().T, left[None], right[None])
    ours = [
        nearest_correspondence(a, b, table_1.fundamental())
        for a, b in zip(left, right, strict=True)
    ]
    assert np.abs(np.array(ours)[:, 0] - corrected[0][0]).max() < 1e-4
    assert np.abs(np.array(ours)[:, 1] - corrected[1][0]).max() < 1e-4


def plane_cost(angle, left, right, rig):
    """Squared distances from the lines in which an epipolar plane at that angle meets the views."""
    baseline = rig.T_lr.t / np.linalg.norm(rig.T_lr.t)
    first = np.cross(baseline, [0.3, 0.5, 0.81])
    first /= np.linalg.norm(first)
    normal = np.multiply.outer(np.cos(angle), first)
    normal = normal + np.multiply.outer(np.sin(angle), np.cross(baseline, first))
    in_left = normal @ np.linalg.inv(rig.left.K)
    in_right = normal @ rig.T_lr.R @ np.linalg.inv(rig.right.K)
    return sum(
        (line[..., :2] @ point + line[..., 2]) ** 2 / (line[..., :2] ** 2).sum(axis=-1)
        for line, point in ((in_left, left), (in_right, right))
    )


def least_over_all_planes(left, right, rig):
    angles = np.linspace(0, np.pi, 2001)
    costs = plane_cost(angles, left, right, rig)
    dips = np.flatnonzero((costs <= np.roll(costs, 1)) & (costs <= np.roll(costs, -1)))
    least = [
        minimize_scalar(
            plane_cost,
            bounds=(angle - 0.002, angle + 0.002),
            args=(left, right, rig),
            method="bounded",
            options={"xatol": 1e-12},
        ).fun
        for angle in angles[dips]
    ]
    return min(least)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    t=st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(30, 80)),
    tips=st.tuples(*[st.floats(0, 900)] * 4),
)
def test_optimal_is_the_global_minimum_even_where_there_are_several(t, tips):
    """One camera looks past the other, so that both epipoles are in the picture, and the points
    have nothing to do with each other: the cost has several minima along the pencil of planes.
    """
    camera = Camera(np.array([[800.0, 0, 450], [0, 820, 440], [0, 0, 1]]), 900, 900)
    rig = StereoRig(camera, camera, Pose(np.eye(3), np.array(t)))
    left, right = np.array(tips[:2]), np.array(tips[2:])
    moved = nearest_correspondence(left, right, rig.fundamental())
    ours = np.sum((moved[0] - left) ** 2) + np.sum((moved[1] - right) ** 2)
    expected = least_over_all_planes(left, right, rig)
    assert ours == pytest.approx(expected, rel=1e-6, abs=1e-6)
    ends = (np.append(p, 1) for p in moved)
    residual = next(ends) @ rig.fundamental() @ next(ends)
    assert abs(residual) < 1e-9


def test_optimal_considers_the_plane_at_infinity_too():
    """In the paper's terms a = 1, b = c = 0, d = 30, f = 1, g = 0.01: the cost is
    t^2 / (1 + t^2) + 900 / (t^2 + 0.09), which falls to 1 as t grows, and no root is there.
    """
    left, right = _nearest_feet(np.array([[1.0, 0.0], [0.0, 30.0]]), 1.0, 0.01)
    assert left == pytest.approx([1, 0], abs=1e-12)
    assert right == pytest.approx([0, 0], abs=1e-12)


def test_optimal_works_where_the_epipoles_are_at_infinity():
    camera = Camera(np.array([[800.0, 0, 450], [0, 800, 450], [0, 0, 1]]), 900, 900)
    rig = StereoRig(camera, camera, Pose(np.eye(3), np.array([60.0, 0, 0])))
    left, right = np.array([500.0, 410.0]), np.array([200.0, 416.0])
    # rectified: the lines are rows, and the nearest common row is the mean
    moved = nearest_correspondence(left, right, rig.fundamental())
    assert moved[0] == pytest.approx([500, 413], abs=1e-9)
    assert moved[1] == pytest.approx([200, 413], abs=1e-9)
    z = 800 * 60 / 300
    expected = [(500 - 450) * z / 800, (413 - 450) * z / 800, z]
    point = triangulate_points(left, right, rig, "optimal")
    assert point == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_the_reprojection_error_is_the_tip_minus_the_projection(distorted, method):
    left, right = distorted.project(np.array([-10.0, 20.0, 170.0]))
    right = right + np.array([0.0, 2.0])
    estimate = triangulate(left, right, distorted, method)
    seen = distorted.project(estimate.point_mm)
    assert estimate.reprojection_px[0] == pytest.approx(left - seen[0], abs=1e-12)
    assert estimate.reprojection_px[1] == pytest.approx(right - seen[1], abs=1e-12)
    assert estimate.reprojection_px[1, 1] > 0.5  # moved down, so below the projection
