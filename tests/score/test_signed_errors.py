"""Do errors have the sign, axis and frame that their names say?"""

import numpy as np
import pytest

from simtip.score import TipError, pixel_error, point_error, score_tip


def test_a_point_error_is_measured_minus_true_per_axis():
    error = point_error([1.0, 5.0, -2.0], [2.0, 2.0, 2.0])
    assert (error.x_mm, error.y_mm, error.z_mm) == (-1, 3, -4)
    assert error.norm_mm == pytest.approx(np.sqrt(26))


def test_a_pixel_error_is_measured_minus_true():
    error = pixel_error([10.0, 20.0], [13.0, 16.0])
    assert (error.u_px, error.v_px) == (-3, 4)
    assert error.norm_px == 5
    assert error.along_px is None
    assert error.across_px is None


@pytest.mark.parametrize(
    ("axis", "moved", "along", "across"),
    [
        # hanging needle, hub above: a tip found too high recedes; right is clockwise of up
        ((0, -1), (0, -6), 6, 0),
        ((0, -1), (0, 6), -6, 0),
        ((0, -1), (2, 0), 0, 2),
        # hub to the right: clockwise of right is down
        ((1, 0), (3, 0), 3, 0),
        ((1, 0), (0, 2), 0, 2),
        # hub below: clockwise of down is left
        ((0, 1), (2, 0), 0, -2),
        ((0.6, -0.8), (0.6, -0.8), 1, 0),
        ((0.6, -0.8), (0.8, 0.6), 0, 1),
    ],
)
def test_along_is_towards_the_hub_and_across_is_clockwise_of_it(axis, moved, along, across):
    true = np.array([100.0, 200.0])
    error = pixel_error(true + moved, true, axis)
    assert (error.along_px, error.across_px) == pytest.approx((along, across), abs=1e-12)
    assert np.hypot(error.along_px, error.across_px) == pytest.approx(error.norm_px)


def test_a_whole_measurement_keeps_its_views_apart():
    error = score_tip(
        point_measured_mm=[1, 2, 3],
        point_true_mm=[1, 2, 2],
        tips_measured_px=([1, 0], [0, 5]),
        tips_true_px=([0, 0], [0, 0]),
        axes_true_px=([0, -1], [0, 1]),
    )
    assert error.point.z_mm == 1
    assert (error.left.u_px, error.left.v_px) == (1, 0)
    assert (error.left.along_px, error.left.across_px) == (0, 1)
    assert (error.right.u_px, error.right.v_px) == (0, 5)
    assert (error.right.along_px, error.right.across_px) == (5, 0)


def test_what_is_missing_stays_missing():
    assert score_tip() == TipError(None, None, None)
    error = score_tip(
        point_true_mm=[1, 2, 3],
        tips_measured_px=(None, [1, 1]),
        tips_true_px=([0, 0], [0, 0]),
        axes_true_px=([0, 1], None),
    )
    assert error.point is None
    assert error.left is None
    assert error.right.norm_px == pytest.approx(np.sqrt(2))
    assert error.right.along_px is None
    assert point_error([1, 2, 3], None) is None


@pytest.mark.parametrize(
    ("measured", "true", "axis"),
    [
        ([1, np.nan], [0, 0], None),
        ([1, 2], [0, np.inf], None),
        ([1, 2, 3], [0, 0, 0], None),
        ([1, 2], [0, 0], [0, 2]),
        ([1, 2], [0, 0], [0, 0]),
        ([1, 2], [0, 0], [np.nan, 0]),
    ],
)
def test_a_number_that_is_none_is_an_error_not_a_score(measured, true, axis):
    with pytest.raises(ValueError, match=r"finite numbers|length 1"):
        pixel_error(measured, true, axis)
