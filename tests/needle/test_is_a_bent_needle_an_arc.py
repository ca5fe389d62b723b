"""Is a bent needle part of a torus, with its tip where the straight one has it?"""

from __future__ import annotations

import math

import numpy as np
import pytest
from tips import ROUND, SHARP, R, depth, planes_of

from simtip.camera import Camera
from simtip.footprint import footprint, in_view
from simtip.needle import Bevel, Blunt, Cone, Lancet, Needle

RHO, LENGTH = 100.0, 150.0
K = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.9], [0, 0, 1]])
CAMERA = Camera(K, 2048, 1436)


def bent(tip, direction=0.0, rho=RHO):
    return Needle(2 * R, LENGTH, tip, rho, direction)


def from_torus(points, direction_deg, rho=RHO):
    """Distance from the torus whose axis is at distance rho towards the direction, and the arc."""
    t = math.radians(direction_deg)
    towards = np.array([math.cos(t), math.sin(t), 0])
    aside = np.array([-math.sin(t), math.cos(t), 0])
    inplane = np.stack([rho - points @ towards, points[:, 2]], axis=1)
    ring = np.hypot(*inplane.T) - rho
    return np.hypot(ring, points @ aside) - R, rho * np.arctan2(inplane[:, 1], inplane[:, 0])


@pytest.mark.parametrize(("direction", "rho"), [(0, RHO), (70, 60.0), (-110, 400.0)])
def test_the_shaft_is_a_torus_to_the_last_point_of_its_faces(direction, rho):
    vertices, faces = bent(Blunt(), direction, rho).surface()
    distance, arc = from_torus(vertices, direction, rho)
    wall = (arc > 1e-9) & (arc < LENGTH - 1e-9)
    assert wall.sum() > 10_000
    assert np.abs(distance[wall]).max() < 1e-11
    assert arc.min() > -1e-12
    assert arc.max() == pytest.approx(LENGTH, abs=1e-9)
    shaft = faces[np.abs(distance[faces]).max(axis=1) < 1e-9]
    weight = np.random.default_rng(0).dirichlet([1, 1, 1], len(shaft))
    points = (vertices[shaft] * weight[..., None]).sum(axis=1)
    assert np.abs(from_torus(points, direction, rho)[0]).max() < 9e-4


@pytest.mark.slow
@pytest.mark.parametrize("name", SHARP)
def test_no_face_of_a_bent_tip_strays_from_the_straight_tips_image(name):
    """Undone by hand: radius and arc in the plane of the bend."""
    vertices, faces = bent(SHARP[name]).surface()
    faces = faces[vertices[faces][..., 2].min(axis=1) < 12]
    weight = np.random.default_rng(1).dirichlet([1, 1, 1], len(faces))
    points = (vertices[faces] * weight[..., None]).sum(axis=1)
    x, y, z = points.T
    straight = np.stack([RHO - np.hypot(RHO - x, z), y, RHO * np.arctan2(z, RHO - x)], axis=1)
    off = depth(name, straight, LENGTH)
    assert np.abs(off).max() < 9e-4


@pytest.mark.slow
@pytest.mark.parametrize("tip", [*SHARP.values(), ROUND["lancet"]])
@pytest.mark.parametrize("direction", [0, 200])
def test_the_tip_and_its_tangent_stay(tip, direction):
    needle, straight = bent(tip, direction), Needle(2 * R, LENGTH, tip)
    np.testing.assert_array_equal(needle.apex, straight.apex)
    vertices, _ = needle.surface()
    assert np.linalg.norm(vertices - needle.apex, axis=1).min() < 1e-13
    assert vertices[:, 2].min() > -1e-13
    T = needle.pose((1, 2, 170), (0.2, -1, 0.1), 40)
    np.testing.assert_allclose(T.apply(needle.apex), (1, 2, 170), atol=1e-12)
    np.testing.assert_allclose(T.R[:, 2], np.array([0.2, -1, 0.1]) / math.sqrt(1.05), atol=1e-14)


def test_the_hub_goes_to_where_the_arc_ends_and_rolls_with_the_needle():
    """150 mm of a 100 mm arc: 1.5 rad, towards +y; a roll of 90 degrees takes that to -x."""
    needle = bent(Cone(5), 90)
    hub = needle.bend.apply([0, 0, LENGTH])
    end = np.array([0, 100 * (1 - math.cos(1.5)), 100 * math.sin(1.5)])
    np.testing.assert_allclose(hub, end, atol=1e-12)
    vertices = needle.surface()[0]
    assert np.linalg.norm(vertices - end, axis=1).min() < 1e-12  # the middle of the hub's face
    rolled = needle.pose((0, 0, 0), (0, 0, 1), 90).apply(end)
    unrolled = needle.pose((0, 0, 0), (0, 0, 1), 0).apply(end)
    np.testing.assert_allclose(rolled, [-unrolled[1], unrolled[0], unrolled[2]], atol=1e-12)


@pytest.mark.parametrize(
    "tip", [Blunt(), *(pytest.param(tip, marks=pytest.mark.slow) for tip in (Cone(5), Bevel(20)))]
)
def test_the_volume_is_pappuss(tip):
    """Of each slice the centroid's way counts: 1 - x / rho; a bevel's slices lie towards +x.

    Rings 0.56 mm apart turn by 5.6e-3 rad; their chords lose that squared over 6, 5.2e-6.
    """
    needle, straight = bent(tip), Needle(2 * R, LENGTH, tip)
    expected = straight.mesh(384).volume
    if isinstance(tip, Bevel):
        expected *= 1 - straight.mesh(384).center_mass[0] / RHO
    assert needle.mesh().volume == pytest.approx(expected * (1 - 5.2e-6), rel=3e-7)


@pytest.mark.slow
def test_a_camera_is_inside_exactly_where_the_solid_is():
    rng = np.random.default_rng(4)
    for name in ("cone", "lancet", "franseen"):
        needle = bent(SHARP[name])
        points = rng.uniform([-R, -R, -1], [R, R, 9], (10, 3))
        for straight, inside in zip(points, depth(name, points, LENGTH), strict=True):
            if abs(inside) > 2e-3:
                x, y, s = straight
                turn = s / RHO
                point = (RHO - (RHO - x) * math.cos(turn), y, (RHO - x) * math.sin(turn))
                assert needle.encloses(point) == (inside > 0), (name, straight)


@pytest.mark.slow
@pytest.mark.parametrize("tip", [Cone(5), ROUND["lancet"]])
@pytest.mark.parametrize("direction", [0, 180, 300])
def test_the_footprint_holds_every_pixel_of_a_bent_needle(tip, direction):
    """Strewn points of the torus, and of the tip's planes' common rim, in closed form."""
    needle = bent(tip, direction)
    T = needle.pose((5, 20, 170), (0.1, -1, 0.1), 30)
    rng = np.random.default_rng(6)
    angle, s = rng.uniform(0, 2 * np.pi, 60_000), rng.uniform(9, LENGTH, 60_000)
    t = math.radians(direction)
    towards, aside = (np.array([math.cos(a), math.sin(a), 0]) for a in (t, t + math.pi / 2))
    across = (RHO - R * np.cos(angle))[:, None]
    turn = (s / RHO)[:, None]
    points = (
        (RHO - across * np.cos(turn)) * towards
        + (R * np.sin(angle))[:, None] * aside
        + across * np.sin(turn) * [0, 0, 1]
    )
    seen = T.apply(np.vstack([points, needle.apexes]))
    pixels = CAMERA.project(seen[seen[:, 2] > 1])
    u, v = np.rint(pixels[CAMERA.contains(pixels)]).astype(int).T
    mask = footprint(needle, T, CAMERA)
    assert in_view(needle, T, CAMERA)
    assert len(u) > 1000
    assert mask[v, u].all()
    touched = np.zeros_like(mask)
    touched[v, u] = True
    # Seven pixels, the tip's front (which is not strewn), and no more.
    assert mask.sum() < 2.2 * touched.sum() + 8000


def test_a_lancets_oracle_has_its_tip_at_zero():
    """The oracle of this folder itself: three planes through or behind (R, 0, 0)."""
    normals, offsets = planes_of("lancet")
    reach = normals @ np.array([R, 0, 0]) - offsets
    np.testing.assert_allclose(reach[:2], 0, atol=1e-12)
    assert reach[2] < 0
    assert Lancet().extent_mm(R) < 2 * R / math.tan(math.radians(12))
