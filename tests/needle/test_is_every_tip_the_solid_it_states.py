"""Is each family's mesh closed, outward, on its own surface, and no further off than 0.9 um?

0.9 um is 0.01 px at the paper's scale, so where no point of any face strays further, no silhouette
does, whatever the view.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial import cKDTree
from tips import BORE, ROUND, SHARP, R, depth, front_z, half_spaces, planes_of

from simtip.needle import BackBevel, Bevel, Blunt, Cone, Diamond, Franseen, Lancet, Needle, Trocar

STRAY_MM = 9e-4
LENGTH = 150.0
EVERY = [*((n, t) for n, t in SHARP.items()), *((n, t) for n, t in ROUND.items())]


def needle_of(tip, **bend):
    return Needle(2 * R, LENGTH, tip, **bend)


def is_lancet(figures):
    try:
        return bool(Lancet(*figures))
    except ValueError:
        return False


def on_faces(vertices, faces, count, seed=3):
    """Points strewn over faces, half of them anywhere, half at the tip, each face alike."""
    rng = np.random.default_rng(seed)
    lowest = vertices[faces][..., 2].min(axis=1)
    tip = np.flatnonzero(lowest < 12)
    pick = np.concatenate([rng.integers(len(faces), size=count), rng.choice(tip, count)])
    weight = rng.dirichlet([1, 1, 1], len(pick))
    return (vertices[faces[pick]] * weight[..., None]).sum(axis=1)


def to_inner(points, normals, offsets, radius, rounds=4000):
    """Distance of points from planes' and a cylinder's common part, by Dykstra's projections."""
    p, kept = points.copy(), np.zeros((len(normals) + 1, *points.shape))
    for _ in range(rounds):
        before = p.copy()
        for k in range(len(normals) + 1):
            q = p + kept[k]
            if k < len(normals):
                out = np.maximum(q @ normals[k] - offsets[k], 0)
                p = q - out[:, None] * normals[k]
            else:
                scale = np.minimum(1, radius / np.maximum(np.hypot(q[:, 0], q[:, 1]), 1e-300))
                p = q * np.stack([scale, scale, np.ones_like(scale)], axis=1)
            kept[k] = q - p
        if np.abs(p - before).max() < 1e-13:
            break
    return np.linalg.norm(points - p, axis=1)


@pytest.mark.parametrize("bend", [None, pytest.param(100.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("tip", [tip for _, tip in EVERY])
def test_closed_outward_and_of_no_more_faces_than_a_renderer_likes(tip, bend):
    mesh = needle_of(tip, bend_radius_mm=bend).mesh()
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.9 * math.pi * R**2 * (LENGTH - 10)
    assert mesh.area_faces.min() > 1e-13
    assert mesh.body_count == 1
    assert len(mesh.faces) < (300_000 if bend else 60_000)


@pytest.mark.parametrize(("name", "tip"), SHARP.items())
def test_every_vertex_of_a_sharp_tip_is_on_it_and_no_face_strays(name, tip):
    vertices, faces = needle_of(tip).surface()
    inside = ~np.isclose(vertices[:, 2], LENGTH) & (np.hypot(*vertices[:, :2].T) > 0)
    assert np.abs(depth(name, vertices[inside], LENGTH)).max() < 1e-9
    off = depth(name, on_faces(vertices, faces, 4000), LENGTH)
    assert off.min() > -(1e-5 if name == "franseen" else 1e-9)  # a bore's chords cut the corner
    assert off.max() < 1e-5


@pytest.mark.parametrize("name", [n for n in ROUND if n not in {"cone", "franseen"}])
def test_every_vertex_of_a_rounded_tip_is_a_balls_and_no_face_strays(name):
    """The oracle knows the planes only: distance r from where a ball's centre can be."""
    tip = ROUND[name]
    r = tip.tip_radius_mm
    normals, offsets = planes_of(name, r)
    vertices, faces = needle_of(tip).surface()
    rng = np.random.default_rng(1)
    some = vertices[rng.choice(np.flatnonzero(vertices[:, 2] < 140), 300)]
    distance = to_inner(some, normals, offsets, R - r)
    # Centres of flat facets and spherical corners, too, are on it; the oracle's own grid is 1e-7.
    np.testing.assert_allclose(distance, r, rtol=0, atol=3e-7)
    points = on_faces(vertices, faces, 300)
    points = points[points[:, 2] < 140]
    off = to_inner(points, normals, offsets, R - r) - r
    assert off.max() < 3e-7
    assert off.min() > -STRAY_MM


@pytest.mark.slow
def test_the_rounded_crown_is_at_its_radius_from_its_inner_front():
    """Not convex, so the oracle is a cloud of the inner front's points, 3 um apart at most."""
    tip, r = ROUND["franseen"], ROUND["franseen"].tip_radius_mm
    normals, offsets = planes_of("franseen", r)
    rng = np.random.default_rng(2)
    angle, share = rng.uniform(0, 2 * np.pi, 400_000), rng.choice([0, 1, 0.5], 400_000)
    share = np.where(share == 0.5, rng.random(400_000), share)
    rho = BORE + r + share * (R - BORE - 2 * r)
    x, y = rho * np.cos(angle), rho * np.sin(angle)
    tree = cKDTree(np.column_stack([x, y, front_z(normals, offsets, x, y)]))
    vertices, faces = needle_of(tip).surface()
    points = np.concatenate([vertices, on_faces(vertices, faces, 4000)])
    rho = np.hypot(*points[:, :2].T)
    points = points[(rho < R - 1e-4) & (rho > BORE + 1e-6) & (points[:, 2] < 3)]  # no walls
    assert len(points) > 5000
    distance = tree.query(points)[0]
    assert distance.min() > r - STRAY_MM
    assert distance.max() < r + STRAY_MM


@pytest.mark.parametrize(("name", "tip"), EVERY)
def test_the_apex_is_a_vertex_and_nothing_is_before_it(name, tip):
    needle = needle_of(tip)
    vertices, _ = needle.surface()
    assert np.linalg.norm(vertices - needle.apex, axis=1).min() < 1e-13
    assert vertices[:, 2].min() > -1e-13
    for apex in needle.apexes:
        assert apex[2] == 0
        assert np.linalg.norm(vertices - apex, axis=1).min() < 1e-13
    first = vertices[vertices[:, 2] < 1e-13]
    if name != "blunt":  # all of its flat is foremost
        gaps = np.linalg.norm(first[:, None] - needle.apexes[None], axis=2).min(axis=1)
        assert gaps.max() < 1e-9


@pytest.mark.parametrize(
    ("tip", "apex"),
    [
        (Cone(5, 0.1), (0, 0, 0)),
        (Bevel(20, 0.1), (R - 0.1, 0, 0)),
        (SHARP["lancet"], (R, 0, 0)),
        (ROUND["lancet"], (R - 0.05, 0, 0)),
        (SHARP["back_bevel"], (0.75 * R, 0, 0)),
        (SHARP["trocar"], (0, 0, 0)),
        (SHARP["diamond"], (0, 0, 0)),
        (SHARP["franseen"], (BORE, 0, 0)),
        (ROUND["franseen"], (BORE + 0.05, 0, 0)),
        (SHARP["blunt"], (0, 0, 0)),
    ],
)
def test_the_apex_is_where_it_is_documented(tip, apex):
    np.testing.assert_allclose(needle_of(tip).apex, apex, rtol=0, atol=1e-14)


def test_the_crowns_three_points_are_equally_foremost():
    apexes = needle_of(SHARP["franseen"]).apexes
    assert len(apexes) == 3
    np.testing.assert_allclose(np.hypot(*apexes[:, :2].T), BORE)
    np.testing.assert_allclose(np.degrees(np.arctan2(apexes[:, 1], apexes[:, 0])), [0, 120, -120])


def integrated(name):
    """Volume of a sharp solid by summing its front over the disc, in polar coordinates."""
    n, m = 2000, 720
    rho, step = (np.arange(n) + 0.5) * R / n, 2 * np.pi / m
    angle = (np.arange(m) + 0.5) * step
    x, y = rho[:, None] * np.cos(angle), rho[:, None] * np.sin(angle)
    front = 5 * rho[:, None] / R + 0 * x if name == "cone" else front_z(*planes_of(name), x, y)
    height = LENGTH - front
    if name == "franseen":
        floor = front_z(*planes_of(name), *(R * np.array([[0.5], [3**0.5 / 2]]))) + 8 * R
        height = np.where(rho[:, None] < BORE, LENGTH - floor, height)
    return float((height * rho[:, None]).sum() * step * R / n)


@pytest.mark.parametrize("name", SHARP)
def test_the_volume_is_the_integral_over_the_disc(name):
    assert needle_of(SHARP[name]).mesh().volume == pytest.approx(integrated(name), rel=2e-5)


def test_a_rounded_cones_volume_is_that_of_its_profile():
    """Profile by hand: ball, tangent cone, shoulder; with the tip radius large enough to matter."""
    r, half = 0.3, math.atan2(R, 5)
    shoulder_z = r + 5 * (R - r) / R

    def squared(z):
        if z < r - r * math.sin(half):
            return 2 * r * z - z * z
        if z < shoulder_z - r * math.sin(half):
            return (R * (z + r / math.sin(half) - r) / 5) ** 2
        return (R - r + math.sqrt(max(r * r - (shoulder_z - z) ** 2, 0))) ** 2

    joints = [r - r * math.sin(half), shoulder_z - r * math.sin(half)]
    front = math.pi * quad(squared, 0, shoulder_z, points=joints, limit=200)[0]
    expected = front + math.pi * R**2 * (LENGTH - shoulder_z)
    needle = needle_of(Cone(5, r))
    assert needle.tip.extent_mm(R) == pytest.approx(shoulder_z, rel=1e-12)
    assert needle.mesh().volume == pytest.approx(expected, rel=4e-5)


def test_a_rounded_blunt_ends_volume_is_pappuss():
    """A quarter disc's complement is turned about the axis: area times its centroid's way."""
    r = 0.2
    area = (1 - math.pi / 4) * r**2
    centroid = R - (10 - 3 * math.pi) / (12 - 3 * math.pi) * r  # from the corner, per spandrel
    expected = math.pi * R**2 * LENGTH - 2 * math.pi * centroid * area
    assert needle_of(Blunt(r)).mesh().volume == pytest.approx(expected, rel=4e-5)


def test_a_rounded_tip_is_inside_the_sharp_one_and_tends_to_it():
    for small in (1e-2, 1e-3, 1e-4):
        for tip in (Lancet(tip_radius_mm=small), Trocar(20, small), Bevel(20, small)):
            sharp = needle_of(type(tip)()) if not isinstance(tip, Bevel) else needle_of(Bevel(20))
            rounded = needle_of(tip)
            # The front recedes by a few radii, and only the front.
            receded = sharp.tip.extent_mm(R) - rounded.tip.extent_mm(R)
            assert 0 < receded < 12 * small


@pytest.mark.parametrize("name", ["trocar", "diamond", "lancet", "back_bevel", "franseen"])
def test_edges_between_planes_are_edges_of_the_mesh(name):
    """Every face of the front lies in one plane, so no face bridges two."""
    vertices, faces = needle_of(SHARP[name]).surface()
    normals = [n for n, _ in half_spaces(name)]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    out = np.cross(b - a, c - a)
    out /= np.linalg.norm(out, axis=1)[:, None]
    front = out[(out[:, 2] < -0.01) & (out[:, 2] > -0.99)]  # neither walls nor a bore's floor
    assert (front @ np.array(normals).T).max(axis=1).min() > 1 - 1e-9
    assert len(front) > 500


rounding = st.sampled_from([0.0, 1e-4]) | st.floats(1e-3, 0.6)
share = st.floats(0.05, 0.95)
angles, turns = st.floats(3, 85), st.floats(1, 89)
any_tip = st.one_of(
    st.builds(Cone, st.floats(0.1, 30), rounding),
    st.builds(Bevel, angles, rounding),
    st.builds(BackBevel, angles, angles, turns, share, rounding),
    st.tuples(angles, angles, turns, share, rounding).filter(is_lancet).map(lambda a: Lancet(*a)),
    st.builds(Trocar, angles, rounding),
    st.builds(Diamond, angles, rounding),
    st.builds(Franseen, angles, st.floats(0.1, 0.9), st.sampled_from([0.0, 1e-4, 5e-3])),
    st.builds(Blunt, rounding),
)


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=150)
@given(any_tip, st.integers(4, 40), st.sampled_from([None, 80.0]), st.floats(0, 360))
def test_any_figures_make_a_closed_solid_with_its_apex_foremost(tip, quarter, rho, direction):
    needle = Needle(2 * R, 220.0, tip, rho, direction)
    vertices, faces = needle.surface(4 * quarter, 0.05)
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    n = len(vertices)
    forth, back = (np.sort(edges @ pair) for pair in ([n, 1], [1, n]))
    assert len(np.unique(forth)) == len(forth)  # no edge twice the same way,
    np.testing.assert_array_equal(forth, back)  # and each once the other way
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = (a * np.cross(b, c)).sum() / 6
    bulk = math.pi * R**2 * (220.0 - tip.extent_mm(R))
    assert 0.3 * bulk < volume < math.pi * R**2 * 220.0
    assert np.linalg.norm(vertices - needle.apex, axis=1).min() < 1e-9
    assert vertices[:, 2].min() > -1e-9
    if rho is None:
        assert np.hypot(vertices[:, 0], vertices[:, 1]).max() < R * (1 + 1e-12)
        assert vertices[:, 2].max() == 220.0


@pytest.mark.parametrize("off", [1e-13, 1e-9, 1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("r", [0.0, 0.01])
def test_an_edge_that_nearly_meets_a_point_of_the_ring_leaves_no_gap(off, r):
    """At side_share 1/2 the side bevels end on the rim at 90 degrees, where the ring has points.

    A share of the first bevel is 7.9 mm of length, so about 17 mm3.
    """
    mesh = needle_of(Lancet(side_share=0.5 + off, tip_radius_mm=r)).mesh(64)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(
        needle_of(Lancet(tip_radius_mm=r)).mesh(64).volume, abs=30 * off + 1e-5
    )


IMPOSSIBLE = {
    "cone, ball too large": (lambda: needle_of(Cone(5, 0.8)), "cone's tip_radius_mm .* 0.7515"),
    "bevel, negative": (lambda: needle_of(Bevel(20, -0.1)), "bevel's tip_radius_mm"),
    "bevel, nan": (lambda: needle_of(Bevel(20, math.nan)), "bevel's tip_radius_mm"),
    "crown, wall too thin": (
        lambda: needle_of(Franseen(tip_radius_mm=0.2)),
        "franseen's tip_radius_mm .* 0.1052, 0.9 of half the wall",
    ),
    "a misprint": (lambda: needle_of(Trocar(20, 1e-7)), "0 or between 0.0001"),
    "trocar, flat": (lambda: Trocar(2), "trocar's angle_deg .* at least 3"),
    "diamond, blunt": (lambda: Diamond(90), "diamond's angle_deg .* below 90"),
    "lancet, no ridge": (lambda: Lancet(12, 11), "side_angle_deg has to be above 16.49"),
    "lancet, share": (lambda: Lancet(side_share=1), "side_share"),
    "crown, all bore": (lambda: Franseen(bore_share=1), "bore_share"),
    "crown, bore longer than the needle": (
        lambda: Needle(2 * R, 8, Franseen()),
        "does not fit .* length_mm has to be above",
    ),
    "bend too tight": (lambda: needle_of(Cone(5), bend_radius_mm=40), "at least 47.7465"),
    "bend too tight for its thickness": (
        lambda: Needle(2, 20, Cone(5), 9.9),
        "bend_radius_mm has to be at least 10 ",
    ),
    "bend of no size": (lambda: needle_of(Cone(5), bend_radius_mm=math.inf), "bend_radius_mm"),
    "bend nowhere": (
        lambda: Needle(2, 20, Cone(5), 100, math.nan),
        "bend_direction_deg",
    ),
}


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_what_is_no_needle_names_its_field_and_range(case):
    make, message = IMPOSSIBLE[case]
    with pytest.raises(ValueError, match=message):
        make()


def test_the_lancets_smallest_side_angle_is_the_smallest():
    with pytest.raises(ValueError, match="side_angle_deg"):
        Lancet(12, 16.47)
    assert needle_of(Lancet(12, 16.5)).mesh().is_watertight
