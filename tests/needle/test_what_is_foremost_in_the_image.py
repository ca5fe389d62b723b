"""Is the silhouette's tip the foremost point of the image, and the axis the image of the axis?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from simtip.camera import Camera
from simtip.needle import Bevel, Cone, Needle
from simtip.silhouette import apex_is_hidden, projected_axis, silhouette_tip

K = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.9], [0, 0, 1]])
PINHOLE = Camera(K, 2048, 1436)
DISTORTED = Camera(K, 2048, 1436, (-0.2, 0.08, 1e-3, -5e-4, 0.01))
CONE = Needle(1.67, 150.0, Cone(5.0))
BEVEL = Needle(1.67, 150.0, Bevel(20.0))

tip_points = st.tuples(st.floats(-50, 50), st.floats(-30, 30), st.floats(120, 220))
hanging = st.tuples(st.floats(-0.6, 0.6), st.just(-1.0), st.floats(-0.6, 0.6))


@settings(derandomize=True, deadline=None, max_examples=25)
@given(tip_points, hanging, st.booleans())
def test_the_axis_is_the_difference_of_two_projections(point, axis, distorted):
    """Oracle: central differences over +-1 um, good to about 1e-8."""
    camera = DISTORTED if distorted else PINHOLE
    T = BEVEL.pose(point, axis, 30)
    step = 1e-3 * T.R[:, 2]
    apart = camera.project(np.array(point) + step) - camera.project(np.array(point) - step)
    expected = apart / np.linalg.norm(apart)
    np.testing.assert_allclose(projected_axis(BEVEL, T, camera), expected, rtol=0, atol=1e-7)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(tip_points, hanging)
def test_a_slender_cones_foremost_point_is_its_apex(point, axis):
    T = CONE.pose(point, axis)
    np.testing.assert_array_equal(
        silhouette_tip(CONE, T, PINHOLE), PINHOLE.project(np.array(point))
    )


@settings(derandomize=True, deadline=None, max_examples=25)
@given(tip_points, hanging, st.floats(0, 360), st.booleans())
def test_a_bevels_foremost_point_is_the_foremost_of_its_rim(point, axis, roll, distorted):
    """Oracle: a continuous search over the cut's rim, which is an ellipse, in closed form.

    The polygon falls short of the ellipse by at most its sagitta, 3.9e-6 mm times 1/sin(20 deg)
    along the cut, times 16 px/mm at 120 mm: 2e-4 px.
    """
    camera = DISTORTED if distorted else PINHOLE
    T = BEVEL.pose(point, axis, roll)
    axis_px = projected_axis(BEVEL, T, camera)

    def depth(angle):
        x, y = 0.835 * np.cos(angle), 0.835 * np.sin(angle)
        z = (0.835 - x) / np.tan(np.radians(20))
        return camera.project(T.apply(np.stack([x, y, z], axis=-1))) @ axis_px

    coarse = np.linspace(0, 2 * np.pi, 721)
    start = coarse[np.argmin(depth(coarse))]
    best = minimize_scalar(depth, bounds=(start - 0.01, start + 0.01), method="bounded")
    found = float(silhouette_tip(BEVEL, T, camera) @ axis_px)
    assert found == pytest.approx(min(best.fun, depth(start)), abs=2e-4)


def test_a_bevel_turned_to_the_side_has_two_different_tips():
    """Leaning towards the camera, the far side of the rim hangs lower than the apex."""
    T = BEVEL.pose((0, 0, 170), (0, -0.3, -1), 90)
    apex = PINHOLE.project(np.array([0.0, 0, 170]))
    assert np.linalg.norm(silhouette_tip(BEVEL, T, PINHOLE) - apex) > 0.5


def test_parts_behind_the_camera_are_no_candidates():
    T = CONE.pose((0, 0, 30), (0, -0.5, -1))  # the hub is at z = -104 mm
    np.testing.assert_array_equal(silhouette_tip(CONE, T, PINHOLE), K[:2, 2])


def test_directions_that_do_not_exist_are_refused():
    with pytest.raises(ValueError, match="straight at the camera"):
        projected_axis(CONE, CONE.pose((0, 0, 170), (0, 0, 1)), PINHOLE)
    with pytest.raises(ValueError, match="in front"):
        projected_axis(CONE, CONE.pose((0, 0, -1), (0, -1, 0)), PINHOLE)


@pytest.mark.parametrize(
    ("needle", "roll", "hidden"),
    [(CONE, 0, True), (BEVEL, -90, True), (BEVEL, 90, False)],
)
def test_the_body_hides_a_tip_that_points_away(needle, roll, hidden):
    """Seen from above, a bevel's apex is hidden on the far side and seen on the near one."""
    T = needle.pose((0, 20, 170), (0, -0.1, -1), roll)
    assert apex_is_hidden(needle, T) is hidden
    assert not apex_is_hidden(needle, needle.pose((0, 20, 170), (0, -0.1, 1), roll))
    assert not apex_is_hidden(needle, needle.pose((0, 20, 170), (0, -1, 0), roll))
