"""F from corner pairs and from the rig, in the paper's order."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip import match
from simtip.calibrate import as_printed, calibrate, eight_point, epipolar_of
from simtip.calibrate.fundamental import scaled
from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose

EQ_16 = np.array(
    [
        [-5.3121e-8, 1.2930e-6, -0.0011],
        [2.2319e-6, -2.1695e-7, 0.0103],
        [-0.0017, -0.0137, 1],
    ]
)


def pairs(rig, points, poses, noise_px=0.0, seed=0):
    views = sightings(rig, points, poses, noise_px, seed)
    return (
        np.concatenate([v.left.pixels for v in views]),
        np.concatenate([v.right.pixels for v in views]),
    )


@pytest.fixture(scope="module")
def pinholes():
    rig = paper_rig((), ())
    return rig, board_poses(rig, grid(), 20)


def test_exact_pairs_give_the_rigs_matrix(pinholes):
    rig, poses = pinholes
    F = eight_point(*pairs(rig, grid(), poses))
    assert np.abs(F / scaled(rig.fundamental()) - 1).max() < 1e-6
    assert np.linalg.norm(F) == pytest.approx(1)
    assert F[2, 2] > 0


def test_it_is_the_printed_matrix_but_for_f33(pinholes):
    rig, poses = pinholes
    printed = as_printed(eight_point(*pairs(rig, grid(), poses)))
    assert printed[2, 2] == 1
    # Table 1 implies an F33 of 2.797 where Eq. 16 prints 1; Table 1 itself has three digits
    ratio = 2.797 * printed / EQ_16
    assert ratio[2, 2] == pytest.approx(2.797)
    others = np.delete(ratio.ravel(), [2, 6, 8])
    assert np.abs(others - 1).max() < 0.02
    assert np.abs(ratio[[0, 2], [2, 0]] - 1).max() < 0.1


def test_opencvs_eight_points_agree_with_noise(pinholes):
    rig, poses = pinholes
    left, right = pairs(rig, grid(), poses, noise_px=0.3)
    theirs, _ = cv2.findFundamentalMat(right, left, cv2.FM_8POINT)
    ours = eight_point(left, right)
    # the scales of the normalisation differ, mean against root mean square
    assert np.abs(ours - scaled(theirs)).max() < 1e-4
    assert np.linalg.matrix_rank(ours / np.abs(ours).max(axis=0), tol=1e-9) == 2
    assert epipolar_of(left, right, ours).symmetric_px.mean() == pytest.approx(
        epipolar_of(left, right, theirs).symmetric_px.mean(), rel=1e-3
    )


def test_without_hartleys_normalisation_it_would_be_worse(pinholes):
    rig, poses = pinholes
    left, right = pairs(rig, grid(), poses, noise_px=0.3)
    p, q = (np.column_stack([x, np.ones(len(x))]) for x in (left, right))
    rows = (p[:, :, None] * q[:, None]).reshape(-1, 9)
    u, s, vt = np.linalg.svd(np.linalg.svd(rows, full_matrices=False)[2][-1].reshape(3, 3))
    plain = u @ np.diag([s[0], s[1], 0]) @ vt
    ours = epipolar_of(left, right, eight_point(left, right)).symmetric_px.mean()
    assert ours < 0.9 * epipolar_of(left, right, plain).symmetric_px.mean()


def test_distances_are_those_of_the_matching(pinholes):
    rig, poses = pinholes
    left, right = pairs(rig, grid(), poses[:3], noise_px=1.0)
    ours = epipolar_of(left, right, rig.fundamental())
    theirs = match.epipolar_distances(left, right, rig)
    assert np.allclose(ours.left_px, theirs[0], rtol=1e-9)
    assert np.allclose(ours.right_px, theirs[1], rtol=1e-9)
    # the paper's Eq. 17, by hand, for one pair
    a, b, c = rig.fundamental().T @ [*left[7], 1]
    assert ours.right_px[7] == pytest.approx(
        abs(a * right[7, 0] + b * right[7, 1] + c) / np.hypot(a, b)
    )


def test_the_summary_sums_up(pinholes):
    rig, poses = pinholes
    distances = epipolar_of(*pairs(rig, grid(), poses, noise_px=0.5), rig.fundamental())
    summary = distances.summary()
    assert summary["mean"] == pytest.approx(distances.right_px.mean())
    assert summary["max"] == distances.right_px.max()
    assert summary["quantiles"]["0.5"] == pytest.approx(np.median(distances.right_px))
    assert sum(summary["histogram"]["counts"]) == 1760
    assert summary["symmetric"]["max"] == pytest.approx(
        ((distances.left_px + distances.right_px) / 2).max()
    )


def test_a_lens_that_distorts_bends_the_lines_of_raw_pixels_only():
    rig, points = paper_rig(), grid(6, 5, 10.0)
    views = sightings(rig, points, board_poses(rig, points, 10), noise_px=0.02)
    calibration = calibrate(views, points, SIZE, SIZE)
    undistorted, raw = (
        calibration.epipolar.right_px.mean(),
        calibration.epipolar_raw.right_px.mean(),
    )
    assert undistorted < 0.03
    assert raw > 3 * undistorted
    assert calibration.epipolar_rig.right_px.mean() == pytest.approx(undistorted, rel=0.2)
    assert np.allclose(calibration.epipolar_rig.F, scaled(calibration.rig.fundamental()))
    assert calibration.to_dict()["epipolar_px"]["mean"] == undistorted


@settings(derandomize=True, deadline=None, max_examples=30)
@given(
    turn=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    shift=st.tuples(st.floats(30, 120), st.floats(-30, 30), st.floats(-30, 30)),
    focal=st.floats(800, 4000),
)
def test_any_rig_is_found_from_its_pairs(turn, shift, focal):
    R, _ = cv2.Rodrigues(np.array(turn))
    left = Camera([[focal, 0, 600], [0, 1.02 * focal, 500], [0, 0, 1]], 1200, 1000)
    right = Camera([[0.9 * focal, 0, 620], [0, focal, 480], [0, 0, 1]], 1200, 1000)
    rig = StereoRig(left, right, Pose(R, shift))
    points = np.random.default_rng(0).uniform([-150, -150, 500], [150, 150, 900], (60, 3))
    # deeper than any of these cameras turned, so that all points are in front of both
    p, q = rig.project(points)
    if not np.isfinite(q).all():
        return
    found = epipolar_of(p, q, eight_point(p, q))
    assert found.symmetric_px.max() < 1e-6
    assert np.abs(np.abs(np.vdot(found.F, rig.fundamental())) - 1) < 1e-9


def test_too_few_or_broken_pairs_are_refused():
    some = np.random.default_rng(0).uniform(0, 1000, (7, 2))
    with pytest.raises(ValueError, match="at least 8 pairs, not 7"):
        eight_point(some, some)
    with pytest.raises(ValueError, match="same length"):
        eight_point(some, some[:5])
    with pytest.raises(ValueError, match="not finite"):
        eight_point(np.full((9, 2), np.nan), np.zeros((9, 2)))
    with pytest.raises(ValueError, match="same"):
        eight_point(np.ones((9, 2)), np.ones((9, 2)))
