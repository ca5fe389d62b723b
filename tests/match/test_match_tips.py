"""Are two tips accepted exactly when they are near enough to each other's epipolar lines?"""

import numpy as np
import pytest

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose
from simtip.match import MatchStatus, epipolar_distances, match_tips

TIP_MM = np.array([-10.0, 20.0, 170.0])


def test_a_true_pair_is_accepted(table_1):
    found = match_tips(*table_1.project(TIP_MM), table_1)
    assert found.ok
    assert (found.status, found.reason) == ("ok", "")
    assert found.distance_px < 1e-9


def test_the_symmetric_distance_is_the_mean_of_both_views(table_1):
    left, right = table_1.project(TIP_MM)
    right = right + np.array([0.5, 1.2])
    found = match_tips(left, right, table_1)
    in_left, in_right = epipolar_distances(left, right, table_1)
    assert found.distance_left_px == pytest.approx(in_left)
    assert found.distance_right_px == pytest.approx(in_right)
    assert abs(in_left - in_right) > 0.01
    assert found.distance_px == pytest.approx((in_left + in_right) / 2)
    assert abs(found.line_right[:2] @ right + found.line_right[2]) == pytest.approx(in_right)
    assert abs(found.line_left[:2] @ left + found.line_left[2]) == pytest.approx(in_left)


def test_a_pair_is_accepted_up_to_the_limit_and_refused_beyond(table_1):
    left, right = table_1.project(TIP_MM)
    right = right + np.array([0, 3.0])
    distance = match_tips(left, right, table_1).distance_px
    assert match_tips(left, right, table_1, max_distance_px=distance).ok
    refused = match_tips(left, right, table_1, max_distance_px=np.nextafter(distance, 0))
    assert refused.status is MatchStatus.OFF_EPIPOLAR_LINE
    assert refused.distance_px == distance


def test_the_limit_is_two_pixels_and_the_reason_has_the_numbers(table_1):
    left, right = table_1.project(TIP_MM)
    for offset, ok in ((1.9, True), (2.2, False)):
        step = offset / match_tips(left, right + np.array([0, 1]), table_1).distance_px
        found = match_tips(left, right + np.array([0, step]), table_1)
        assert found.distance_px == pytest.approx(offset, rel=1e-3)
        assert found.ok is ok
    assert "2.20 px" in found.reason
    assert "2 px is allowed" in found.reason
    assert found.status == "off_epipolar_line"


def test_distortion_is_undone_first(distorted):
    left, right = distorted.project(TIP_MM + np.array([20, 25, 0]))
    assert match_tips(left, right, distorted).distance_px < 1e-6


def test_a_tip_at_the_epipole_is_refused_with_its_reason():
    camera = Camera(np.array([[1000.0, 0, 500], [0, 1000, 400], [0, 0, 1]]), 1000, 800)
    rig = StereoRig(camera, camera, Pose(np.eye(3), np.array([0.0, 0.0, 100.0])))
    found = match_tips([500, 400], [510, 400], rig)
    assert found.status == "at_epipole"
    assert found.reason
    assert found.distance_px is None


@pytest.mark.parametrize("tip", [[np.nan, 1], [1, 2, 3], 4, [[1, 2]]])
def test_what_is_no_tip_is_an_error(table_1, tip):
    with pytest.raises(ValueError, match="two finite numbers"):
        match_tips(tip, [1, 2], table_1)
    with pytest.raises(ValueError, match="two finite numbers"):
        match_tips([1, 2], tip, table_1)
