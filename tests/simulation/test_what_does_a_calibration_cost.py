"""Does a rendered needle, measured with an imperfect rig, err as the error map says?

The images and the detector's own error are the same with either rig: what differs is due to the
calibration alone.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from regions import with_roi

from simtip.calibrate import error_map
from simtip.camera import StereoRig
from simtip.geometry import Pose
from simtip.rig_file import write_rig
from simtip.spec import SceneSpec
from simtip.trial import run_trial

OFF_MM = np.array([0.05, -0.02, 0.08])
ROIS = [700, 700, 220, 240], [910, 695, 220, 240]


@pytest.fixture(scope="module")
def imperfect(scene) -> StereoRig:
    """A calibration that is off, of the whole sensors."""
    true = scene.rig.rig()
    left, right = (
        replace(camera, K=camera.K + np.array([[f, 0, u], [0, f, v], [0, 0, 0]]))
        for camera, f, u, v in ((true.left, 1.5, 0.8, -0.6), (true.right, -2, 0.5, 1.1))
    )
    turn, _ = cv2.Rodrigues(np.radians([0.02, -0.05, 0.03]))
    return StereoRig(left, right, Pose(turn @ true.T_lr.R, true.T_lr.t + OFF_MM))


def measured(scene: SceneSpec, path: str | None) -> np.ndarray:
    data = with_roi(scene, *ROIS, noise=None, samples=64, crop=True).model_dump(mode="json")
    data["rig"]["measured"] = path
    data["detect"]["min_area_px"], data["match"]["max_distance_px"] = 500, 10
    trial = run_trial(SceneSpec.model_validate(data), seed=3)
    assert trial.ok, trial.measurement.reason
    return trial.measurement.tip_mm


@pytest.mark.slow
@pytest.mark.parametrize("form", ["rig.yaml", "rig.json"])
def test_the_error_map_tells_what_the_needle_loses(scene, imperfect, tmp_path, form):
    write_rig(tmp_path / form, imperfect)
    seen, true = measured(scene, str(tmp_path / form)), measured(scene, None)
    # The tips' rays miss each other by a little, which the map's points do not: hence 1 %.
    box = error_map(scene.rig.rig(), imperfect, true - 0.5, true + 0.5, (3, 3, 3), step_mm=0.1)
    expected = box.displacement_mm.mean(axis=0)
    assert np.linalg.norm(expected) > 0.1
    np.testing.assert_allclose(seen - true, expected, atol=0.01 * np.linalg.norm(expected))
