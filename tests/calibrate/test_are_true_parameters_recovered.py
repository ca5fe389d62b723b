"""Noise-free corners in, true parameters out; and the optimum is the one that others find."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import LensModel, View, calibrate, compare
from simtip.calibrate.bundle import adjust
from simtip.calibrate.problem import Unknowns, linearised, residuals
from simtip.calibrate.selection import screened
from simtip.target.sighting import Sighting

POINTS = grid(6, 5, 10.0)
WIDE = grid(9, 7, 10.0)
RATIONAL = (8, 4, 1e-3, -5e-4, 0.2, 8.3, 6, 1.2)
STRONG = (-0.3, 0.12, 0.001, -0.002, 0.01)


def slow(*case):
    return pytest.param(*case, marks=pytest.mark.slow)


def relative_errors(comparison):
    for p in comparison.parameters:
        # what is truly zero is held against 1: px, mm, or a coefficient
        yield p.name, abs(p.error) / (abs(p.true) or 1.0)


@pytest.mark.parametrize(
    ("model", "left_d", "right_d", "bar"),
    [
        ("none", (), (), 1e-9),
        slow("radial2", (-0.11, 0.15, 0, 0), (-0.1, 0.12, 0, 0), 1e-9),
        slow("radtan", (-0.11, 0.15, 1e-3, -5e-4), (-0.1, 0.12, -8e-4, 6e-4), 1e-9),
        slow("opencv5", (-0.11, 0.15, 4e-4, -3e-4, -0.05), (-0.1, 0.12, -3e-4, 5e-4, -0.02), 1e-9),
        slow("opencv5", (), (), 1e-9),
        ("opencv5", STRONG, STRONG, 1e-9),
        # numerator and denominator nearly cancel, which costs digits
        slow("rational", RATIONAL, RATIONAL, 1e-6),
        slow("auto", (-0.11, 0.15, 0, 0), (-0.1, 0.12, 0, 0), 1e-9),
    ],
)
def test_noise_free_corners_give_the_true_rig(model, left_d, right_d, bar):
    rig = paper_rig(left_d, right_d)
    views = sightings(rig, WIDE, board_poses(rig, WIDE, 8, reach_mm=(40, 30, 30)))
    calibration = calibrate(views, WIDE, SIZE, SIZE, model=model)
    comparison = compare(calibration, rig)
    assert calibration.views_rejected == calibration.corners_rejected == calibration.warnings == ()
    assert max(calibration.rms_px.values()) < 1e-9
    worst = max(relative_errors(comparison), key=lambda pair: pair[1])
    assert worst[1] < bar, worst


@pytest.mark.slow
def test_the_papers_set_is_recovered_with_88_corners_and_20_pairs():
    rig, points = paper_rig(), grid()
    poses = board_poses(rig, points, 20)
    calibration = calibrate(sightings(rig, points, poses), points, SIZE, SIZE)
    assert len(calibration.left.corners) == 1760
    assert max(error for _, error in relative_errors(compare(calibration, rig))) < 1e-9
    for found, true in zip(calibration.board_poses, poses, strict=True):
        assert np.abs(found.matrix() - true.matrix()).max() < 1e-7


def test_the_pose_is_the_papers_and_not_opencvs():
    rig = paper_rig()
    views = sightings(rig, POINTS, board_poses(rig, POINTS, 8))
    entry = calibrate(views, POINTS, SIZE, SIZE).to_dict()
    # P_l = R P_r + T: the origin of the right camera lies at T in the left one's frame
    assert np.allclose(entry["R"], rig.T_lr.R, atol=1e-9)
    assert np.allclose(entry["T_mm"], [72.047, 2.138, 14.041], atol=1e-9)
    assert entry["baseline_mm"] == pytest.approx(np.linalg.norm([72.047, 2.138, 14.041]))


@pytest.fixture(scope="module")
def noisy():
    rig = paper_rig()
    return sightings(rig, POINTS, board_poses(rig, POINTS, 8), noise_px=0.05, seed=2)


def stacked(views, camera):
    return [getattr(v, camera).pixels.astype(np.float32) for v in views]


def test_opencvs_joint_calibration_finds_the_same_optimum(noisy):
    # OpenCV reads single precision, so both are given what it can read
    views = [
        View(
            v.name,
            *(replace(s, pixels=np.float64(np.float32(s.pixels))) for s in (v.left, v.right)),
        )
        for v in noisy
    ]
    ours = calibrate(views, POINTS, SIZE, SIZE)
    left, right = ours.rig.left, ours.rig.right
    start = [left.K * [[1.001], [1.001], [1]], np.zeros((1, 5)), right.K.copy(), np.zeros((1, 5))]
    rms, K_l, D_l, K_r, D_r, R, T, *_ = cv2.stereoCalibrate(
        [POINTS.astype(np.float32)] * len(views),
        stacked(views, "left"),
        stacked(views, "right"),
        *start,
        SIZE,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS,
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 300, 1e-14),
    )
    std = ours.std
    assert ours.rms_px["stereo"] == pytest.approx(rms, rel=1e-6)
    assert ours.rms_px["stereo"] <= rms * (1 + 1e-9)
    # a hundredth of a standard deviation: OpenCV stops where the cost is flat
    assert (np.abs(K_l - left.K) <= 0.01 * std.K_left + 1e-12).all()
    assert (np.abs(K_r - right.K) <= 0.01 * std.K_right + 1e-12).all()
    assert (np.abs(np.ravel(D_l) - left.distortion) <= 0.01 * std.D_left).all()
    assert (np.abs(np.ravel(D_r) - right.distortion) <= 0.01 * std.D_right).all()
    assert np.abs(R.T - ours.rig.T_lr.R).max() < 0.01 * std.R.max()
    assert np.abs(-R.T @ T.ravel() - ours.rig.T_lr.t).max() < 0.01 * std.T_mm.max()


def opencv_residuals(x, views, free):
    """The whole problem once more, from cv2.projectPoints alone and with rotation vectors."""
    intrinsics, (r, T), boards = x[: 2 * free], x[2 * free :][:6].reshape(2, 3), x[2 * free + 6 :]
    R_lr = Rotation.from_rotvec(r).as_matrix()
    out = []
    for view, (rb, tb) in zip(views, boards.reshape(-1, 2, 3), strict=True):
        Rb = Rotation.from_rotvec(rb).as_matrix()
        sides = ((view.left, Rb, tb), (view.right, R_lr.T @ Rb, R_lr.T @ (tb - T)))
        for (sighting, R, t), c in zip(sides, intrinsics.reshape(2, free), strict=True):
            if sighting is not None:
                K = np.array([[c[0], 0, c[2]], [0, c[1], c[3]], [0, 0, 1]])
                turn = Rotation.from_matrix(R).as_rotvec()
                modelled, _ = cv2.projectPoints(POINTS[sighting.ids], turn, t, K, c[4:])
                out.append(sighting.pixels - modelled.reshape(-1, 2))
    return np.concatenate(out).ravel()


@pytest.mark.slow
def test_views_of_one_camera_count_as_in_scipys_least_squares(noisy):
    views = [
        replace(v, left=None) if i == 1 else replace(v, right=None) if i == 3 else v
        for i, v in enumerate(noisy[:5])
    ]
    ours = calibrate(views, POINTS, SIZE, SIZE)
    assert ours.views_used == tuple(v.name for v in views)
    rig = ours.rig

    def packed(camera):
        return [*camera.K[[0, 1, 0, 1], [0, 1, 2, 2]], *camera.distortion]

    boards = [(Rotation.from_matrix(p.R).as_rotvec(), p.t) for p in ours.board_poses]
    relative = [Rotation.from_matrix(rig.T_lr.R).as_rotvec(), rig.T_lr.t]
    best = np.concatenate(
        [packed(rig.left), packed(rig.right), np.ravel(relative), np.ravel(boards)]
    )
    rng = np.random.default_rng(0)
    start = best * (1 + 1e-5 * rng.standard_normal(best.size))
    theirs = least_squares(
        opencv_residuals, start, x_scale="jac", args=(views, 9), xtol=1e-12, ftol=1e-15, gtol=1e-12
    )
    ours_cost = (opencv_residuals(best, views, 9) ** 2).sum()
    assert ours_cost <= 2 * theirs.cost * (1 + 1e-9)
    # the same minimum, in units of what noise does to each unknown
    J = theirs.jac
    scatter = np.sqrt(np.diagonal(np.linalg.inv(J.T @ J)) * ours.uncertainty.sigma_px**2)
    assert (np.abs(theirs.x - best) / scatter).max() < 1e-2
    names = ours.uncertainty.names
    assert np.allclose([ours.uncertainty.std(name) for name in names[:18]], scatter[:18], rtol=1e-3)
    assert np.allclose(ours.std.T_mm, scatter[21:24], rtol=1e-3)
    at = 24 + 6 * 3  # the pose of the fourth view, seen by the left camera only
    pose = np.sqrt(np.diagonal(ours.uncertainty.pose_covariances[3])[3:])
    assert np.allclose(pose, scatter[at + 3 : at + 6], rtol=1e-3)


@pytest.mark.slow
def test_more_views_of_one_camera_sharpen_that_camera_most(noisy):
    few = calibrate(noisy[:4], POINTS, SIZE, SIZE).uncertainty
    left_too = [*noisy[:4], *(replace(v, right=None) for v in noisy[4:])]
    more = calibrate(left_too, POINTS, SIZE, SIZE).uncertainty
    gain = {
        name: (few.std(name) / few.sigma_px) / (more.std(name) / more.sigma_px)
        for name in ("left.fx", "left.cx", "right.fx", "right.cx")
    }
    assert gain["left.fx"] > 1.1
    assert gain["left.cx"] > 1.1
    # what the left camera knows better helps the right one a little, through the shared boards
    assert 1 <= gain["right.fx"] < gain["left.fx"]
    assert 1 <= gain["right.cx"] < gain["left.cx"]


@pytest.mark.parametrize("model", ["none", "opencv5", "rational"])
def test_the_derivatives_are_those_of_the_residuals(noisy, model):
    problem = screened([replace(noisy[0], right=None), *noisy[1:4]], POINTS).problem(
        LensModel(model)
    )
    numbers = np.array([1900, 1910, 930, 660, -0.1, 0.1, 1e-3, -1e-3, 0.02, 0.05, 0.02, 0.01])
    rig = paper_rig()
    poses = board_poses(rig, POINTS, 8)[:4]
    at = Unknowns(
        numbers,
        numbers * 1.01,
        rig.T_lr.R,
        rig.T_lr.t,
        np.stack([p.R for p in poses]),
        np.stack([p.t for p in poses]),
    )
    s, none = problem.shared, np.zeros((4, 6))
    scale = np.ones(s)
    free = len(problem.model.free)
    scale[:4] = scale[free : free + 4] = 1000
    left, right = linearised(problem, at)
    for step in (*(np.eye(s) * scale), *np.eye(6)):
        shared, pose = (step, none) if len(step) == s else (np.zeros(s), np.tile(step, (4, 1)))
        h = 1e-6
        ahead = residuals(problem, at.moved(h * shared, h * pose, problem))
        back = residuals(problem, at.moved(-h * shared, -h * pose, problem))
        by_left = left.camera @ shared[:free] + (left.board @ pose[0])
        of_right = np.concatenate([right.camera, right.relative], axis=2)
        by_right = of_right @ shared[free:] + right.board @ pose[0]
        for a, b, analytic in zip(ahead, back, (by_left, by_right), strict=True):
            numeric = (b - a) / (2 * h)
            assert np.abs(numeric - analytic).max() < 1e-6 * np.abs(analytic).max() + 1e-6


@pytest.mark.slow
def test_the_order_of_the_views_and_missing_points_do_not_matter(noisy):
    some = np.sort(np.random.default_rng(1).permutation(len(POINTS))[:20])
    partial = replace(noisy[2], left=Sighting(noisy[2].left.ids[some], noisy[2].left.pixels[some]))
    views = [*noisy[:2], partial, *noisy[3:]]
    forth = calibrate(views, POINTS, SIZE, SIZE)
    back = calibrate(views[::-1], POINTS, SIZE, SIZE)
    assert np.allclose(forth.rig.left.K, back.rig.left.K, rtol=1e-9)
    assert np.allclose(forth.rig.T_lr.matrix(), back.rig.T_lr.matrix(), rtol=1e-8, atol=1e-9)
    assert len(forth.left.corners) == 7 * 30 + 20
    assert len(forth.epipolar.left_px) == 7 * 30 + 20


def test_the_same_views_give_the_same_bits(noisy):
    before = cv2.getNumThreads()
    cv2.setNumThreads(4)  # whatever the machine; several threads of OpenCV add up in any order
    try:
        rigs = [calibrate(noisy, POINTS, SIZE, SIZE).rig for _ in range(5)]
        assert cv2.getNumThreads() == 4
    finally:
        cv2.setNumThreads(before)
    assert len({rig.left.K.tobytes() + rig.T_lr.t.tobytes() for rig in rigs}) == 1


@pytest.mark.slow
def test_a_far_start_ends_at_the_same_place(noisy):
    ours = calibrate(noisy, POINTS, SIZE, SIZE)
    problem = screened(noisy, POINTS).problem(LensModel.OPENCV5)
    rng = np.random.default_rng(8)
    rig, poses = paper_rig((), ()), board_poses(paper_rig(), POINTS, 8)
    start = Unknowns(
        np.array([2000, 2000, 1000, 700, *[0] * 8], dtype=np.float64),
        np.array([2000, 2000, 1000, 700, *[0] * 8], dtype=np.float64),
        Rotation.from_rotvec([0.02, -0.03, 0.01]).as_matrix() @ rig.T_lr.R,
        rig.T_lr.t + np.array([5.0, -3.0, 4.0]),
        Rotation.from_rotvec(0.05 * rng.standard_normal((8, 3))).as_matrix()
        @ np.stack([p.R for p in poses]),
        np.stack([p.t for p in poses]) + 5 * rng.standard_normal((8, 3)),
    )
    fit = adjust(problem, start)
    assert fit.converged
    assert np.allclose(fit.at.T, ours.rig.T_lr.t, atol=1e-7)
    assert np.allclose(fit.at.left[:4], ours.rig.left.K[[0, 1, 0, 1], [0, 1, 2, 2]], rtol=1e-9)
