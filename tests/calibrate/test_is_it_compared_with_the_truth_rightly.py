"""Are errors signed, scaled and shaped as stated?"""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import calibrate, compare
from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Pose

POINTS = grid(6, 5, 10.0)


@pytest.fixture(scope="module")
def calibration():
    rig = paper_rig()
    return calibrate(sightings(rig, POINTS, board_poses(rig, POINTS, 8), 0.05), POINTS, SIZE, SIZE)


def test_each_error_is_measured_less_true(calibration):
    found = calibration.rig
    K = found.left.K - [[2.0, 0, -3.0], [0, -4.0, 5.0], [0, 0, 0]]
    turn = Rotation.from_euler("y", -0.3, degrees=True).as_matrix()
    true = StereoRig(
        Camera(K, *SIZE, distortion=(np.array(found.left.distortion) - [0.1, 0, 0, 0, 0])),
        found.right,
        Pose(turn @ found.T_lr.R, found.T_lr.t - [1.0, 0, 0]),
    )
    comparison = compare(calibration, true)
    assert comparison["left.fx"].error == pytest.approx(2)
    assert comparison["left.fy"].error == pytest.approx(-4)
    assert comparison["left.cx"].error == pytest.approx(-3)
    assert comparison["left.cy"].error == pytest.approx(5)
    assert comparison["left.k1"].error == pytest.approx(0.1)
    assert comparison["right.fx"].error == 0
    assert comparison["rotation_y_deg"].error == pytest.approx(0.3)
    assert comparison["rotation_x_deg"].error == pytest.approx(0, abs=1e-9)
    assert comparison["T_x_mm"].error == pytest.approx(1)
    assert comparison.rotation_deg == pytest.approx(0.3)
    assert comparison.translation_mm == pytest.approx([1, 0, 0])
    shorter = np.linalg.norm(found.T_lr.t - [1.0, 0, 0])
    assert comparison.baseline_mm == pytest.approx(np.linalg.norm(found.T_lr.t) - shorter)
    assert comparison.focal_percent[0] == pytest.approx(200 / K[0, 0])
    assert comparison.principal_point_px == pytest.approx([-3, 5, 0, 0])
    claimed = calibration.std.K_left[0, 0]
    assert comparison["left.fx"].z == pytest.approx(2 / claimed)
    assert comparison["left.k4"].z is None
    assert comparison.mahalanobis > 10


def test_the_truth_itself_has_no_error(calibration):
    comparison = compare(calibration, calibration.rig)
    assert comparison.mahalanobis == pytest.approx(0, abs=1e-6)
    assert comparison.rotation_deg == pytest.approx(0, abs=1e-9)


def test_truth_of_another_kind_is_refused(calibration):
    rig = calibration.rig
    cropped = replace(rig, left=rig.left.cropped(0, 0, 100, 100))
    with pytest.raises(InputError, match="100 x 100"):
        compare(calibration, cropped)
    prism = replace(rig.left, distortion=(*rig.left.distortion, 0, 0, 0, 1e-3, 0, 0, 0))
    with pytest.raises(InputError, match="thin-prism"):
        compare(calibration, replace(rig, left=prism))


def test_the_json_has_what_was_promised(calibration):
    entry = json.loads(json.dumps(calibration.to_dict(), allow_nan=False))
    assert set(entry["rms_px"]) == {"left", "right", "stereo"}
    left = calibration.left.residual_px
    assert entry["rms_px"]["left"] == pytest.approx(np.sqrt((left**2).sum(axis=1).mean()))
    # noise of 0.05 px in u and in v
    assert entry["rms_px"]["stereo"] == pytest.approx(0.05 * np.sqrt(2), rel=0.1)
    for key in ("K_left", "D_left", "K_right", "D_right", "R", "T_mm", "baseline_mm"):
        assert np.shape(entry["std"][key]) == np.shape(entry[key]), key
    assert np.shape(entry["F"]) == (3, 3)
    assert {"mean", "max"} <= set(entry["epipolar_px"])
    assert entry["views_rejected"] == []
    assert [v["view"] for v in entry["per_view"]] == list(calibration.views_used)
    of_views = [v["left"]["rms_px"] for v in entry["per_view"]]
    assert np.sqrt(np.mean(np.square(of_views))) == pytest.approx(entry["rms_px"]["left"])
    json.dumps(compare(calibration, paper_rig()).to_dict(), allow_nan=False)
