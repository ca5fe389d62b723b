"""Standard deviations claimed from one set against the scatter over many."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import calibrate, compare
from simtip.calibrate.bundle import adjust
from simtip.calibrate.lens_model import LensModel
from simtip.calibrate.problem import Unknowns
from simtip.calibrate.selection import screened
from simtip.calibrate.uncertainty import deviations, uncertainty_of

pytestmark = pytest.mark.slow

POINTS = grid(6, 5, 10.0)
NOISE_PX = 0.05
SETS = 200


@pytest.fixture(scope="module")
def sets():
    """Errors and claimed deviations of every shared unknown, over independent corner noise."""
    rig = paper_rig()
    poses = board_poses(rig, POINTS, 8)
    exact = screened(sightings(rig, POINTS, poses), POINTS).problem(LensModel.OPENCV5)
    true = Unknowns(
        *(
            np.array([*c.K[[0, 1, 0, 1], [0, 1, 2, 2]], *c.distortion, 0, 0, 0])
            for c in (rig.left, rig.right)
        ),
        rig.T_lr.R,
        rig.T_lr.t,
        np.stack([p.R for p in poses]),
        np.stack([p.t for p in poses]),
    )
    rng = np.random.default_rng(11)

    def noisy(corners):
        noise = NOISE_PX * rng.standard_normal(corners.pixels.shape)
        return replace(corners, pixels=corners.pixels + noise)

    errors, claims, covariances, sigmas = [], [], [], []
    for _ in range(SETS):
        problem = replace(exact, left=noisy(exact.left), right=noisy(exact.right))
        fit = adjust(problem, true)
        claimed = uncertainty_of(problem, fit)
        std = deviations(claimed, problem, fit)
        turn = Rotation.from_matrix(fit.at.R @ true.R.T).as_rotvec()
        length = np.linalg.norm(fit.at.T) - np.linalg.norm(true.T)
        cameras = [(fit.at.left - true.left)[:9], (fit.at.right - true.right)[:9]]
        shared = [*cameras, turn, fit.at.T - true.T]
        errors.append(np.concatenate([*shared, (fit.at.R - true.R).ravel(), [length]]))
        claims.append([*np.sqrt(np.diagonal(claimed.covariance)), *std.R.ravel(), std.baseline_mm])
        covariances.append(claimed.covariance)
        sigmas.append(claimed.sigma_px)
    return claimed.names, np.array(errors), np.array(claims), np.array(covariances), sigmas


def test_every_parameter_scatters_as_claimed(sets):
    names, errors, claims, _, _ = sets
    ratio = errors.std(axis=0, ddof=1) / np.sqrt((claims**2).mean(axis=0))
    named = dict(zip([*names, *(f"R{i}" for i in range(9)), "baseline"], ratio, strict=True))
    # 200 sets give each ratio to 5 %
    assert all(0.8 < r < 1.25 for r in named.values()), named
    assert 0.93 < np.sqrt((ratio[:24] ** 2).mean()) < 1.07


def test_the_correlations_are_as_claimed_too(sets):
    names, errors, _, covariances, _ = sets
    shared = errors[:, : len(names)]
    squares = [e @ np.linalg.solve(C, e) for e, C in zip(shared, covariances, strict=True)]
    # chi squared of 24 unknowns: a mean over 200 sets scatters by 2 %
    assert np.mean(squares) / len(names) == pytest.approx(1, abs=0.1)


def test_the_noise_is_found_in_the_residuals(sets):
    sigmas = sets[4]
    assert np.mean(sigmas) == pytest.approx(NOISE_PX, rel=0.01)


def test_nothing_is_biased(sets):
    _, errors, _, _, _ = sets
    z = errors.mean(axis=0) / errors.std(axis=0, ddof=1) * np.sqrt(SETS)
    # the high radial coefficients are biased by a fifth of their scatter: a second-order effect
    assert np.abs(np.delete(z, [4, 5, 8, 13, 14, 17])).max() < 4
    assert np.abs(z).max() < 6


def test_the_whole_calibration_at_the_papers_geometry_is_as_good_as_it_says():
    rig, points = paper_rig(), grid()
    shares, focal, centre, baseline = [], [], [], []
    for seed in range(3):
        poses = board_poses(rig, points, 20, seed=seed)
        calibration = calibrate(
            sightings(rig, points, poses, NOISE_PX, seed=seed), points, SIZE, SIZE
        )
        comparison = compare(calibration, rig)
        assert calibration.views_rejected == calibration.corners_rejected == ()
        assert calibration.warnings == ()
        shares.append(comparison.mahalanobis)
        focal.append(np.abs(comparison.focal_percent).max())
        centre.append(np.abs(comparison.principal_point_px).max())
        baseline.append(abs(comparison.baseline_mm))
        assert comparison.rotation_deg < 4 * np.linalg.norm(calibration.std.rotation_deg)
    assert np.sqrt(np.mean(np.square(shares))) == pytest.approx(1, abs=0.25)
    assert max(focal) < 0.1
    assert max(centre) < 1
    assert max(baseline) < 0.05
