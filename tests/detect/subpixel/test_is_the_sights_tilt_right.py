"""Is the needle's slope in depth that of the cylinder whose silhouette is seen?"""

import numpy as np
import pytest

from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.sight import tilt

FOCAL, CENTRE, ROWS = 1900.0, np.array([930.0, 650.0]), 300


def silhouette(point, axis, radius, v):
    """Left and right u at rows v of a round bar: where planes through the eye touch it."""
    axis = axis / np.linalg.norm(axis)
    foot = point - (point @ axis) * axis  # of the perpendicular from the eye to the bar's axis
    away = np.linalg.norm(foot)
    side = np.cross(axis, foot / away)
    angle = np.arcsin(radius / away)
    planes = [
        np.cross(axis, np.cos(angle) * foot / away + sign * np.sin(angle) * side)
        for sign in (1, -1)
    ]
    y = (v - CENTRE[1]) / FOCAL
    u = [CENTRE[0] - FOCAL * (n[1] * y + n[2]) / n[0] for n in planes]
    return np.minimum(*u), np.maximum(*u)


def seen(tip, hub, radius):
    """A shaft as a perfect fit would give it."""
    v_tip = FOCAL * tip[1] / tip[2] + CENTRE[1]
    v = np.linspace(v_tip - ROWS, v_tip, 60)
    left, right = silhouette(tip, hub, radius, v)
    t = (v - v_tip) / ROWS
    axis = np.polynomial.polynomial.polyfit(t, (left + right) / 2, 3)
    slope = np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(axis)) / ROWS
    width = np.polynomial.polynomial.polyfit(t, (right - left) / 2 / np.hypot(1, slope), 2)
    flat = np.full(2, 0.3)
    return Shaft(v_tip, ROWS, axis, width, flat, flat, np.zeros((9, 9)), 1.0), v_tip


@pytest.mark.parametrize("lean", [-0.5, 0.0, 0.6])
@pytest.mark.parametrize("depth", [-0.7, -0.2, 0.0, 0.3, 0.9])
@pytest.mark.parametrize("tip", [(-10.0, 20.0, 170.0), (45.0, 30.0, 150.0)])
def test_it_is_that_of_the_bar(tip, lean, depth):
    tip, hub = np.array(tip), np.array([lean, -1.0, depth])
    shaft, v = seen(tip, hub, 0.835)
    expected = hub @ tip / np.linalg.norm(hub) / np.linalg.norm(tip)
    assert tilt(shaft, v, FOCAL, CENTRE) == pytest.approx(expected, abs=0.02)
