"""Does the pose put the apex where it is asked to, and turn the needle as documented?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simtip.needle import Bevel, Cone, Needle

BEVEL = Needle(1.67, 150.0, Bevel(20.0))
CONE = Needle(1.67, 150.0, Cone(5.0))

coordinates = st.floats(-300, 300)
points = st.tuples(coordinates, coordinates, coordinates)
axes = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 1e-3)
rolls = st.floats(-720, 720)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(points, axes, rolls)
def test_the_apex_lands_on_the_point_and_z_on_the_axis(point, axis, roll):
    for needle in (BEVEL, CONE):
        T = needle.pose(point, axis, roll)
        np.testing.assert_allclose(T.apply(needle.apex), point, rtol=0, atol=2e-13)
        np.testing.assert_allclose(
            T.rotate([0, 0, 1]), axis / np.linalg.norm(axis), rtol=0, atol=1e-14
        )


@settings(derandomize=True, deadline=None, max_examples=100)
@given(axes, rolls)
def test_roll_is_right_handed_about_the_axis(axis, roll):
    """Oracle: scipy's rotation vector along the axis, applied after the unrolled pose."""
    z = np.asarray(axis) / np.linalg.norm(axis)
    turn = Rotation.from_rotvec(np.radians(roll) * z).as_matrix()
    rolled, straight = BEVEL.pose((0, 0, 0), axis, roll), BEVEL.pose((0, 0, 0), axis)
    np.testing.assert_allclose(rolled.R, turn @ straight.R, rtol=0, atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(axes)
def test_zero_roll_keeps_x_as_near_to_world_x_as_the_axis_allows(axis):
    z = np.asarray(axis) / np.linalg.norm(axis)
    assume(abs(z[0]) < 0.999)
    x = BEVEL.pose((0, 0, 0), axis).R[:, 0]
    assert x @ z == pytest.approx(0, abs=1e-14)
    assert x[0] == pytest.approx(np.sqrt(1 - z[0] ** 2), rel=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_along_world_x_zero_roll_keeps_x_on_world_z(sign):
    T = BEVEL.pose((0, 0, 0), (sign, 0, 0))
    np.testing.assert_allclose(T.R[:, 0], [0, 0, 1], atol=1e-15)


def test_the_default_axis_gives_the_documented_frame():
    T = BEVEL.pose((0, 0, 0), (0, -1, 0))
    np.testing.assert_allclose(T.R, np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]).T, atol=0)


@pytest.mark.parametrize("tilt", [(1e-6, 0, 0), (0, 0, 1e-6), (-1e-6, 0, 1e-6)])
def test_the_frame_turns_smoothly_around_the_default_axis(tilt):
    still = BEVEL.pose((0, 0, 0), (0, -1, 0))
    moved = BEVEL.pose((0, 0, 0), np.add((0, -1, 0), tilt))
    assert np.abs(moved.R - still.R).max() < 2e-6


def test_an_axis_without_length_is_refused():
    with pytest.raises(ValueError, match="direction"):
        CONE.pose((0, 0, 0), (0, 0, 0))
