"""Does `auto` take the model that the lens has, no more and no less?"""

from dataclasses import replace

import numpy as np
import pytest
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import LensModel, calibrate, compare
from simtip.target.sighting import Sighting

pytestmark = pytest.mark.slow

POINTS = grid(6, 5, 10.0)


@pytest.mark.parametrize(
    ("expected", "left_d", "right_d"),
    [
        ("none", (), ()),
        ("radial2", (-0.11, 0.15, 0, 0), (-0.1, 0.12, 0, 0)),
        ("opencv5", (-0.11, 0.15, 2e-3, -1e-3, -0.3), (-0.1, 0.12, -1e-3, 2e-3, -0.3)),
        ("radtan", (-0.11, 0.15, 2e-3, -1e-3), (-0.1, 0.12, -1e-3, 2e-3)),
    ],
)
def test_the_least_model_that_explains_the_corners_is_chosen(expected, left_d, right_d):
    rig = paper_rig(left_d, right_d)
    views = sightings(rig, POINTS, board_poses(rig, POINTS, 10), noise_px=0.05, seed=1)
    calibration = calibrate(views, POINTS, SIZE, SIZE, model="auto")
    assert calibration.model == expected
    assert set(calibration.criterion) == set(LensModel)
    assert max(abs(compare(calibration, rig).focal_percent)) < 0.1


def test_wrong_corners_do_not_decide():
    rig = paper_rig((-0.11, 0.15, 0, 0), (-0.1, 0.12, 0, 0))
    views = sightings(rig, POINTS, board_poses(rig, POINTS, 10), noise_px=0.05, seed=1)
    for i in (2, 5):
        pixels = views[i].left.pixels.copy()
        pixels[7] += 30
        views[i] = replace(views[i], left=Sighting(views[i].left.ids, pixels))
    calibration = calibrate(views, POINTS, SIZE, SIZE, model="auto")
    assert calibration.model == "radial2"
    assert [(c.view, c.id) for c in calibration.corners_rejected] == [("03", 7), ("06", 7)]


def test_what_a_model_leaves_out_is_zero_and_certain():
    rig = paper_rig((-0.11, 0.15, 0, 0), (-0.1, 0.12, 0, 0))
    views = sightings(rig, POINTS, board_poses(rig, POINTS, 8), noise_px=0.05)
    entry = calibrate(views, POINTS, SIZE, SIZE, model="radial2").to_dict()
    assert entry["D_left"][2:] == entry["std"]["D_left"][2:] == [0, 0, 0]
    assert np.all(np.array(entry["std"]["D_left"][:2]) > 0)
    entry = calibrate(views, POINTS, SIZE, SIZE, model="rational").to_dict()
    assert len(entry["D_left"]) == len(entry["std"]["D_left"]) == 8
    bare = calibrate(views, POINTS, SIZE, SIZE, model="none").to_dict()
    assert bare["D_left"] == bare["std"]["D_left"] == []
