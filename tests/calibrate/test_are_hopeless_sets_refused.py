"""Sets that no calibration can come from: one line that says what is wrong and what to do."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_sightings import SIZE, board_poses, grid, paper_rig, sightings

from simtip.calibrate import View, calibrate
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.target.sighting import Sighting

POINTS = grid(6, 5, 10.0)
RIG = paper_rig()
POSES = board_poses(RIG, POINTS, 8)
VIEWS = sightings(RIG, POINTS, POSES, 0.05, seed=3)


def refused(views, points=POINTS, size=SIZE, **options):
    with pytest.raises(InputError) as caught:
        calibrate(views, points, size, SIZE, **options)
    error = caught.value
    assert error.field
    assert "\n" not in str(error)
    return error


def test_two_views_are_too_few():
    error = refused(VIEWS[:2])
    assert error.field == "views"
    assert "2 views" in error.problem
    assert "twenty" in error.remedy
    assert calibrate(VIEWS[:3], POINTS, SIZE, SIZE).uncertainty.degrees_of_freedom == 318


def test_three_views_that_are_not_shared_are_too_few():
    views = [replace(v, right=None) for v in VIEWS[:3]] + [
        replace(v, left=None) for v in VIEWS[3:6]
    ]
    assert "0 views seen by both" in refused([*views, View("none", None, None)]).problem


@pytest.mark.parametrize("noise_px", [0.0, 0.05])
def test_parallel_boards_leave_the_focal_length_open(noise_px):
    shifts = np.random.default_rng(1).uniform(-8, 8, (8, 3))
    poses = [Pose(POSES[0].R, POSES[0].t + shift) for shift in shifts]
    error = refused(sightings(RIG, POINTS, poses, noise_px))
    assert "parallel" in error.problem
    assert "tilt" in error.remedy


def facing(angles, tilt_deg=0.0, depth=170.0):
    middle = POINTS.mean(axis=0)
    tilt = Rotation.from_euler("y", -15 + tilt_deg, degrees=True)
    for k, angle in enumerate(angles):
        R = (tilt * Rotation.from_rotvec([0, 0, angle])).as_matrix()
        yield Pose(R, np.array([0, 0, depth + 3 * k]) - R @ middle)


def test_turning_boards_in_their_plane_does_not_help():
    poses = list(facing(np.linspace(-0.5, 0.5, 8)))
    assert "parallel" in refused(sightings(RIG, POINTS, poses, 0.05)).problem


def test_nearly_parallel_boards_are_refused_by_what_they_leave_open():
    tilts = np.linspace(-2.5, 2.5, 8)
    poses = [next(facing([0.1 * k], t)) for k, t in enumerate(tilts)]
    error = refused(sightings(RIG, POINTS, poses, 0.05))
    assert "do not determine the left camera" in error.problem
    # noise-free corners would hide it in the residuals, not in the equations
    assert "do not determine" in refused(sightings(RIG, POINTS, poses)).problem


def test_swapped_cameras_are_seen_by_the_baseline():
    error = refused([View(v.name, v.right, v.left) for v in VIEWS])
    assert "swapped" in error.problem
    assert "exchange" in error.remedy


def test_mirrored_images_are_refused():
    def mirrored(sighting):
        return Sighting(sighting.ids, sighting.pixels * [-1, 1] + [SIZE[0] - 1, 0])

    error = refused([View(v.name, mirrored(v.left), mirrored(v.right)) for v in VIEWS])
    assert "mirrored" in error.problem
    assert "not flipped" in error.remedy


def test_pairs_that_do_not_belong_together_are_refused():
    views = [replace(v, right=VIEWS[(i + 1) % 8].right) for i, v in enumerate(VIEWS)]
    error = refused(views)
    assert "agree" in error.problem
    assert "paired" in error.remedy


def test_points_outside_the_image_are_a_matter_of_sizes():
    error = refused(VIEWS, size=(1280, 1024))
    assert "outside the image of 1280 x 1024" in error.problem
    assert error.field.endswith("left")


def test_numbers_that_the_target_does_not_have_name_the_target():
    error = refused(VIEWS, points=grid(5, 5, 10.0))
    assert "0 to 24" in error.problem
    assert "target" in error.remedy


def test_another_grid_with_as_many_points_does_not_fit():
    error = refused(VIEWS, points=grid(5, 6, 10.0))
    assert "do not lie as on the target" in error.problem


def test_a_target_that_is_not_flat_is_refused():
    points = POINTS + np.arange(len(POINTS))[:, None] * [0, 0, 1.0]
    assert "not flat" in refused(VIEWS, points=points).problem


def test_a_name_given_twice_is_refused():
    assert refused([*VIEWS, VIEWS[0]]).field == "01"


def test_an_unknown_model_is_refused():
    error = refused(VIEWS, model="fisheye")
    assert "fisheye" in error.problem
    assert "rational" in error.remedy
