"""Is the mesh closed, outward, and exactly the solid that its parameters state?"""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.needle import SEGMENTS, Bevel, Cone, Needle

CONE = Needle(1.67, 150.0, Cone(5.0))
BEVEL = Needle(1.67, 150.0, Bevel(20.0))

tips = st.one_of(
    st.floats(0.1, 15).map(Cone),
    st.floats(10, 80).map(Bevel),
)
needles = st.builds(Needle, st.floats(0.2, 3), st.floats(40, 300), tips)
sides = st.integers(2, 64).map(lambda k: 4 * k)


def polygon_area(radius, n):
    return n / 2 * radius**2 * math.sin(2 * math.pi / n)


def volume(needle, area):
    """Closed forms; a bevelled cylinder's cut removes area times the cut's height on the axis."""
    if isinstance(needle.tip, Cone):
        return area * (needle.length_mm - needle.tip.length_mm * 2 / 3)
    axis_height = needle.radius_mm / math.tan(math.radians(needle.tip.angle_deg))
    return area * (needle.length_mm - axis_height)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(needles, sides)
def test_closed_outward_and_of_the_polygonal_volume(needle, n):
    mesh = needle.mesh(n)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    expected = volume(needle, polygon_area(needle.radius_mm, n))
    assert mesh.volume == pytest.approx(expected, rel=1e-10)  # positive: outward


@pytest.mark.parametrize("needle", [CONE, BEVEL])
def test_volume_tends_to_the_round_needles(needle):
    """The polygon's area falls short of the circle's by (2 pi / n)^2 / 6: 6.3e-6 for 1024."""
    round_volume = volume(needle, math.pi * needle.radius_mm**2)
    short = 1 - needle.mesh().volume / round_volume
    assert short == pytest.approx((2 * math.pi / SEGMENTS) ** 2 / 6, rel=1e-4)


@pytest.mark.parametrize("needle", [CONE, BEVEL])
def test_diameter_and_length_are_exact(needle):
    low, high = needle.mesh().bounds
    np.testing.assert_array_equal(low[:2], [-0.835, -0.835])
    np.testing.assert_array_equal(high[:2], [0.835, 0.835])
    assert high[2] == 150.0
    assert low[2] == 0.0


@settings(derandomize=True, deadline=None, max_examples=40)
@given(needles, sides)
def test_every_vertex_is_on_the_circle_or_inside_and_the_ring_is_on_it(needle, n):
    vertices, _ = needle.surface(n)
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    on_circle = np.abs(radius - needle.radius_mm) < 1e-14 * needle.radius_mm * 8
    assert on_circle.sum() == 2 * n
    assert (radius[~on_circle] == 0).all()


@settings(derandomize=True, deadline=None, max_examples=40)
@given(needles, sides)
def test_the_apex_is_a_vertex_and_nothing_is_before_it(needle, n):
    vertices, _ = needle.surface(n)
    nearest = np.linalg.norm(vertices - needle.apex, axis=1).min()
    assert nearest < 1e-14
    assert vertices[:, 2].min() >= needle.apex[2]
    assert needle.apex[2] == 0


def test_the_cone_has_its_apex_on_the_axis_and_its_length():
    np.testing.assert_array_equal(CONE.apex, [0, 0, 0])
    z = np.unique(CONE.surface()[0][:, 2])
    np.testing.assert_array_equal(z, [0, 5, 150])


def test_the_bevel_is_a_plane_at_its_angle_through_the_apex():
    np.testing.assert_array_equal(BEVEL.apex, [0.835, 0, 0])
    mesh = BEVEL.mesh()
    cut = mesh.vertices[:, 2] < 149
    angle = math.radians(20)
    normal = np.array([-math.sin(angle) / math.tan(angle), 0, -math.sin(angle)])
    assert np.linalg.norm(normal) == pytest.approx(1)
    heights = (mesh.vertices[cut] - BEVEL.apex) @ normal
    assert np.abs(heights).max() < 1e-13
    # Its faces look forward, and towards -x, away from the apex's side.
    on_cut = cut[mesh.faces].all(axis=1)
    np.testing.assert_allclose(mesh.face_normals[on_cut], np.tile(normal, (1024, 1)), atol=1e-9)
    assert mesh.vertices[cut][:, 2].max() == pytest.approx(1.67 / math.tan(angle), rel=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Needle(0, 150, Cone(5)), "diameter_mm"),
        (lambda: Needle(float("nan"), 150, Cone(5)), "diameter_mm"),
        (lambda: Needle(1.67, -1, Cone(5)), "length_mm"),
        (lambda: Needle(1.67, float("inf"), Cone(5)), "length_mm"),
        (lambda: Cone(0), "cone"),
        (lambda: Needle(1.67, 150, Cone(150)), "does not fit"),
        (lambda: Needle(1.67, 90, Bevel(1)), "does not fit"),
        (lambda: Bevel(0.99), "angle_deg"),
        (lambda: Bevel(1e-320), "angle_deg"),
        (lambda: Bevel(90), "angle_deg"),
        (lambda: Bevel(float("nan")), "angle_deg"),
        (lambda: CONE.mesh(6), "segments"),
        (lambda: CONE.mesh(1022), "segments"),
    ],
)
def test_what_is_no_needle_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.slow
def test_trimesh_is_loaded_only_for_a_mesh():
    code = "import sys, simtip.needle; sys.exit('trimesh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
