"""Does registration give the rigid motion, its error, and refuse what leaves it open?"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from simtip.capability import register

SOURCE = np.array([[0, 0, 0], [50, 5, 0], [10, 40, 3], [-20, 10, 30], [7, -33, 12.0]])
MOTION = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix(), np.array([100.0, -20.0, 170.0])


def moved(points=SOURCE, noise=0.0):
    R, t = MOTION
    return points @ R.T + t + noise * np.random.default_rng(3).normal(size=points.shape)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_an_exact_motion_is_found_from_three_points_on(count):
    found = register(SOURCE[:count], moved()[:count])
    assert np.abs(found.R - MOTION[0]).max() < 1e-12
    assert found.t == pytest.approx(MOTION[1], abs=1e-10)
    assert found.fre == pytest.approx(0, abs=1e-12)
    assert found.apply(SOURCE) == pytest.approx(moved(), abs=1e-10)


def test_a_mirror_image_gets_a_rotation_all_the_same():
    found = register(SOURCE, SOURCE * [1, 1, -1])
    assert np.linalg.det(found.R) == pytest.approx(1)
    assert found.fre > 1
    flat = SOURCE * [1, 1, 0]
    assert register(flat, flat * [-1, 1, 1]).fre == pytest.approx(0, abs=1e-12)


def test_no_other_motion_fits_better():
    target = moved(noise=0.5)
    found = register(SOURCE, target)

    def residual(p):
        return (SOURCE @ Rotation.from_rotvec(p[:3]).as_matrix().T + p[3:] - target).ravel()

    start = [*Rotation.from_matrix(found.R).as_rotvec(), *found.t]
    best = least_squares(residual, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.fre**2 * 5 == pytest.approx(2 * best.cost, rel=1e-10)
    R = Rotation.from_rotvec(best.x[:3]).as_matrix()
    assert np.abs(found.R - R).max() < 1e-6
    assert (found.residuals**2).sum() / 5 == pytest.approx(found.fre**2)
    # Information of the six numbers at the optimum, by least_squares' own derivative.
    turn = np.zeros((15, 6))
    about = target.mean(axis=0)
    for k in range(3):
        turn[:, k] = np.cross(np.eye(3)[k], found.apply(SOURCE) - about).ravel()
        turn[k::3, 3 + k] = 1
    expected = found.fle_variance * np.linalg.inv(turn.T @ turn)
    assert found.covariance == pytest.approx(expected, rel=0.03, abs=2e-5)


def test_the_error_of_a_point_is_fitzpatricks():
    found = register(SOURCE, moved(noise=0.2))
    point = np.array([160.0, -60.0, 300.0])
    target = moved(noise=0.2)
    centre = target.mean(axis=0)
    _, _, axes = np.linalg.svd(target - centre)
    total = 0.0
    for axis in axes:
        d2 = ((point - centre) ** 2).sum() - ((point - centre) @ axis) ** 2
        f2 = np.mean(((target - centre) ** 2).sum(axis=1) - ((target - centre) @ axis) ** 2)
        total += d2 / f2
    fle2 = found.fre**2 / (1 - 2 / 5)
    assert found.tre(point) ** 2 == pytest.approx(fle2 / 5 * (1 + total / 3), rel=1e-10)
    assert found.to_dict()["fle_rms_mm"] == pytest.approx(math.sqrt(fle2), rel=1e-12)
    assert found.tre(centre) == pytest.approx(math.sqrt(fle2 / 5), rel=1e-10)


LINE = np.outer([0, 1, 2, 5.0], [1, 2, 3.0])


@pytest.mark.parametrize(
    ("source", "target", "problem"),
    [
        (SOURCE[:2], SOURCE[:2], "at least 3 are needed"),
        (LINE, LINE + 1, "source points lie on a line"),
        (SOURCE[:4], LINE, "target points lie on a line"),
        (np.ones((4, 3)), np.ones((4, 3)), "in one place"),
        (SOURCE, SOURCE[:4], r"not \(5, 3\) and \(4, 3\)"),
        (SOURCE[:, :2], SOURCE[:, :2], r"points \(n, 3\)"),
        (SOURCE * np.nan, SOURCE, "not finite"),
    ],
)
def test_what_leaves_the_rotation_open_is_refused(source, target, problem):
    with pytest.raises(ValueError, match=problem):
        register(source, target)


def test_a_tetrahedron_and_its_mirror_image_do_not_say_which_rotation():
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
    with pytest.raises(ValueError, match="do not fit each other"):
        register(corners, -corners)
