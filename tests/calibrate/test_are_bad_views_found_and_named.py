"""Views and corners that do not fit: found, named with a reason, and without effect."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_sightings import SIZE, board_poses, grid, paper_rig, seen, sightings

from simtip.calibrate import LensModel, View, calibrate, compare
from simtip.calibrate.bundle import adjust
from simtip.calibrate.outliers import scatter_of_views
from simtip.calibrate.problem import Unknowns
from simtip.calibrate.selection import screened
from simtip.calibrate.symmetry import symmetries
from simtip.geometry import Pose
from simtip.target.sighting import Sighting

pytestmark = pytest.mark.slow

POINTS = grid(6, 5, 10.0)
COUNT = 10
NOISE_PX = 0.05
RIG = paper_rig()
POSES = board_poses(RIG, POINTS, COUNT)
VIEWS = sightings(RIG, POINTS, POSES, NOISE_PX, seed=3)


def calibrated(views, points=POINTS, **options):
    return calibrate(views, points, SIZE, SIZE, **options)


def with_left(index, pixels, ids=None):
    views = list(VIEWS)
    ids = VIEWS[index].left.ids if ids is None else ids
    views[index] = replace(VIEWS[index], left=Sighting(ids, pixels))
    return views


def moved_before_the_right_exposure(views, index, shift_mm):
    T = Pose(POSES[index].R, POSES[index].t + shift_mm)
    pixels = seen(RIG.right, RIG.T_lr.inverse() @ T, POINTS)
    noise = NOISE_PX * np.random.default_rng(99 + index).standard_normal(pixels.shape)
    changed = list(views)
    changed[index] = replace(views[index], right=Sighting(views[index].right.ids, pixels + noise))
    return changed


def is_sound(calibration):
    """The truth lies within what is claimed, so nothing wrong is left in."""
    comparison = compare(calibration, RIG)
    return 0.5 < comparison.mahalanobis < 1.6 and 0.045 < calibration.uncertainty.sigma_px < 0.055


def test_good_views_are_all_kept():
    calibration = calibrated(VIEWS)
    assert is_sound(calibration)
    assert calibration.views_rejected == calibration.corners_rejected == calibration.warnings == ()
    assert calibration.views_turned == ()


@pytest.mark.parametrize("shift_mm", [(5, 0, 0), (0, 0, 5), (0.5, 0, 0), (0, 0, 0.5), (0, 0.1, 0)])
def test_a_board_that_moved_between_the_exposures_is_named_with_how_far(shift_mm):
    calibration = calibrated(moved_before_the_right_exposure(VIEWS, 4, shift_mm))
    (rejected,) = calibration.views_rejected
    assert rejected.view == "05"
    assert "moved" in rejected.reason
    stated = float(rejected.reason.split("places ")[1].split(" mm")[0])
    assert stated == pytest.approx(np.linalg.norm(shift_mm), rel=0.2)
    assert is_sound(calibration)
    assert "05" not in calibration.views_used


def test_a_move_too_small_for_the_scatter_shows_in_the_pair(monkeypatch):
    views = moved_before_the_right_exposure(VIEWS, 4, (0.05, 0, 0))
    calibration = calibrated(views)
    (rejected,) = calibration.views_rejected
    assert rejected.view == "05"
    assert "moved" in rejected.reason
    assert is_sound(calibration)
    monkeypatch.setattr("simtip.calibrate.outliers.PAIR_MEDIANS", np.inf)
    assert not is_sound(calibrated(views))


def test_undetected_it_would_have_spoilt_the_calibration(monkeypatch):
    views = moved_before_the_right_exposure(VIEWS, 4, (0.5, 0, 0))
    monkeypatch.setattr("simtip.calibrate.run.VIEW_SHARE", 0.0)
    calibration = calibrated(views)
    assert calibration.views_rejected == ()
    assert not is_sound(calibration)


def test_several_moved_boards_are_all_named():
    views = moved_before_the_right_exposure(VIEWS, 1, (0.4, 0, 0))
    views = moved_before_the_right_exposure(views, 5, (0, 0.5, 0))
    views = moved_before_the_right_exposure(views, 8, (20, 5, 0))
    calibration = calibrated(views)
    assert sorted(r.view for r in calibration.views_rejected) == ["02", "06", "09"]
    assert is_sound(calibration)


def test_no_more_than_the_stated_share_is_left_out_and_that_is_said():
    views = VIEWS
    shifts = {0: (0.5, 0, 0), 2: (0, 1, 0), 5: (0, 0, 2), 7: (1, -1, 0)}
    for i, shift_mm in shifts.items():
        views = moved_before_the_right_exposure(views, i, shift_mm)
    calibration = calibrated(views)
    assert sorted(r.view for r in calibration.views_rejected) == ["03", "06", "08"]
    assert any("view 01" in w and "30%" in w for w in calibration.warnings)


def test_a_set_in_which_half_the_pairs_are_wrong_is_warned_of():
    views = VIEWS
    for i in range(5):
        views = moved_before_the_right_exposure(views, i, 0.3 * np.array([(-1) ** i, 1, i - 2]))
    assert any("each alone" in warning for warning in calibrated(views).warnings)


def test_a_view_is_judged_by_what_the_others_say_of_it():
    # of five views, each has pulled the cameras its way, and in its own eyes fits too well
    poses = POSES[:5]
    squares = []
    for seed in range(40):
        problem = screened(sightings(RIG, POINTS, poses, NOISE_PX, seed), POINTS).problem(
            LensModel.OPENCV5
        )
        start = Unknowns(
            *(
                np.array([*c.K[[0, 1, 0, 1], [0, 1, 2, 2]], *c.distortion, 0, 0, 0])
                for c in (RIG.left, RIG.right)
            ),
            RIG.T_lr.R,
            RIG.T_lr.t,
            np.stack([p.R for p in poses]),
            np.stack([p.t for p in poses]),
        )
        fit = adjust(problem, start)
        squares.append(scatter_of_views(problem, fit).px ** 2)
    # the mean over 200 views scatters by 1 %
    assert np.mean(squares) == pytest.approx(NOISE_PX**2, rel=0.05)


def test_a_blurred_view_is_named_by_its_scatter():
    noise = 0.4 * np.random.default_rng(5).standard_normal((len(POINTS), 2))
    calibration = calibrated(with_left(3, VIEWS[3].left.pixels + noise))
    (rejected,) = calibration.views_rejected
    assert rejected.view == "04"
    stated = float(rejected.reason.split("scatter by ")[1].split(" px")[0])
    assert stated == pytest.approx(0.4, rel=0.2)
    assert is_sound(calibration)


@pytest.mark.parametrize("off_px", [0.5, 3.0, 80.0])
def test_a_wrong_corner_goes_alone_and_is_listed(off_px):
    pixels = VIEWS[3].left.pixels.copy()
    pixels[12] += [off_px, 0]
    calibration = calibrated(with_left(3, pixels))
    (corner,) = calibration.corners_rejected
    assert (corner.view, corner.camera, corner.id) == ("04", "left", 12)
    assert corner.residual_px == pytest.approx(off_px, abs=0.15)
    assert calibration.views_rejected == ()
    assert is_sound(calibration)
    assert len(calibration.left.corners) == COUNT * len(POINTS) - 1


def test_many_wrong_corners_take_the_view_with_them():
    pixels = VIEWS[3].left.pixels.copy()
    pixels[[1, 5, 9, 17, 20, 28]] += 4 * np.random.default_rng(1).standard_normal((6, 2))
    calibration = calibrated(with_left(3, pixels))
    assert [r.view for r in calibration.views_rejected] == ["04"]
    assert calibration.corners_rejected == ()
    assert is_sound(calibration)


def test_points_with_shuffled_numbers_are_named():
    shuffled = np.random.default_rng(2).permutation(VIEWS[3].left.pixels)
    calibration = calibrated(with_left(3, shuffled))
    (rejected,) = calibration.views_rejected
    assert rejected.view == "04"
    assert "left camera sees points that do not lie as on the target" in rejected.reason
    assert is_sound(calibration)


def test_a_row_counted_wrongly_is_named():
    right = VIEWS[5].right
    views = list(VIEWS)
    views[5] = replace(VIEWS[5], right=Sighting(right.ids[:-6], right.pixels[6:]))
    calibration = calibrated(views)
    (rejected,) = calibration.views_rejected
    assert rejected.view == "06"
    assert "10 mm" in rejected.reason
    assert "numbered differently" in rejected.reason


def test_a_mirrored_view_is_named():
    pixels = VIEWS[2].left.pixels * [-1, 1] + [SIZE[0] - 1, 0]
    calibration = calibrated(with_left(2, pixels))
    (rejected,) = calibration.views_rejected
    assert (rejected.view, rejected.reason) == ("03", "the left camera sees the target mirrored")
    assert is_sound(calibration)


def test_too_few_points_or_a_single_row_are_named():
    left = VIEWS[2].left
    calibration = calibrated(with_left(2, left.pixels[:7], left.ids[:7]))
    assert "sees 7 points" in calibration.views_rejected[0].reason
    points = grid(9, 4, 8.0)
    views = sightings(RIG, points, board_poses(RIG, points, 8), NOISE_PX)
    views[2] = replace(views[2], left=Sighting(np.arange(9), views[2].left.pixels[:9]))
    assert "one line" in calibrated(views, points).views_rejected[0].reason


def test_a_target_not_found_is_listed_and_one_found_once_is_used():
    views = [*VIEWS, View("none", None, None), replace(VIEWS[0], name="half", right=None)]
    calibration = calibrated(views)
    (rejected,) = calibration.views_rejected
    assert (rejected.view, rejected.reason) == ("none", "the target was found in neither image")
    assert "half" in calibration.views_used


def half_turned(sighting):
    return Sighting(sighting.ids, sighting.pixels[::-1])


@pytest.mark.parametrize("which", [{2}, {1, 4, 6, 7}, set(range(COUNT))])
@pytest.mark.parametrize("camera", ["left", "right"])
def test_a_half_turn_between_left_and_right_is_put_right(which, camera):
    views = [
        replace(v, **{camera: half_turned(getattr(v, camera))}) if i in which else v
        for i, v in enumerate(VIEWS)
    ]
    calibration = calibrated(views)
    assert calibration.views_turned == tuple(f"{i + 1:02d}" for i in sorted(which))
    assert calibration.views_rejected == ()
    assert is_sound(calibration)
    assert np.allclose(calibration.rig.T_lr.t, calibrated(VIEWS).rig.T_lr.t, atol=1e-6)


def test_a_half_turn_that_cannot_be_is_named():
    views = [replace(v, right=half_turned(v.right)) if i == 4 else v for i, v in enumerate(VIEWS)]
    calibration = calibrated(views, turnable=False)
    (rejected,) = calibration.views_rejected
    assert rejected.view == "05"
    assert "180 degrees" in rejected.reason
    assert is_sound(calibration)


def test_quarter_turns_of_a_square_target_are_put_right():
    points = grid(5, 5, 10.0)
    views = sightings(RIG, points, board_poses(RIG, points, 8), NOISE_PX)
    numbers = np.arange(25).reshape(5, 5)
    turned = [
        replace(v, right=Sighting(v.right.ids, v.right.pixels[np.rot90(numbers, i).ravel()]))
        for i, v in enumerate(views)
    ]
    calibration = calibrated(turned, points)
    assert calibration.views_turned == ("02", "03", "04", "06", "07", "08")
    assert np.allclose(calibration.rig.T_lr.t, calibrated(views, points).rig.T_lr.t, atol=1e-6)


def test_the_symmetries_are_those_of_the_target():
    assert sorted(symmetries(grid(11, 8, 6.0))) == [0, 180]
    assert sorted(symmetries(grid(7, 7, 3.0))) == [0, 90, 180, 270]
    # OpenCV's asymmetric circles, 4 x 11: every other row is shifted
    asymmetric = np.array(
        [[(2 * j + i % 2) * 5.0, i * 5.0, 0] for i in range(11) for j in range(4)]
    )
    assert sorted(symmetries(asymmetric)) == [0]
    numbering = symmetries(grid(3, 2, 1.0))[180]
    assert numbering.tolist() == [5, 4, 3, 2, 1, 0]
