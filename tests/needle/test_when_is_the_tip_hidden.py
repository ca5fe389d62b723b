"""Does the needle hide its tip exactly when some of it lies between tip and camera?

Oracle: points along the way from the camera to the tip, tested against the solid's closed form.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from tips import SHARP, R, depth

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.needle import BackBevel, Bevel, Blunt, Cone, Diamond, Franseen, Lancet, Needle, Trocar
from simtip.silhouette import apex_is_hidden, projected_axis, silhouette_tip

LENGTH, RHO = 60.0, 40.0
K = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.9], [0, 0, 1]])
CAMERA = Camera(K, 2048, 1436)


def looked_at_from(centre):
    """T_cn of a camera at a point of the needle's frame; which way it is turned is no matter."""
    return Pose(np.eye(3), -np.asarray(centre))


def centres(count, seed):
    """Around the tip, 20 to 200 mm off: half of them anywhere, half behind it."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(count, 3))
    d[::2] = d[::2] * [0.2, 0.2, 1]
    d[::2, 2] = np.abs(d[::2, 2]) + 0.7
    return d / np.linalg.norm(d, axis=1)[:, None] * rng.uniform(20, 200, (count, 1))


def along(centre, apex):
    """Points on the way, dense at the tip, none nearer than 2 um."""
    way = np.geomspace(2e-3, np.linalg.norm(centre - apex), 1500)
    direction = (centre - apex) / np.linalg.norm(centre - apex)
    return apex + way[:, None] * direction


def in_solid(name, points, rho):
    if rho:
        x, y, z = points.T
        points = np.stack([rho - np.hypot(rho - x, z), y, rho * np.arctan2(z, rho - x)], axis=1)
    return depth(name, points, LENGTH)


@pytest.mark.parametrize("rho", [None, pytest.param(RHO, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", SHARP)
def test_hidden_is_what_the_solid_hides(name, rho):
    needle = Needle(2 * R, LENGTH, SHARP[name], rho)
    found = {True: 0, False: 0}
    for centre in centres(60, 7):
        if needle.encloses(centre):
            continue
        deepest = in_solid(name, along(centre, needle.apex), rho).max()
        # Grazing rays, where 128 sides and the round solid may differ, decide nothing.
        if abs(deepest) > 6e-4:
            hidden = apex_is_hidden(needle, looked_at_from(centre))
            assert hidden == (deepest > 0), (name, centre)
            found[hidden] += 1
        elif deepest < 0:
            assert not apex_is_hidden(needle, looked_at_from(centre))
            found[False] += 1
    assert min(found.values()) > 5, found


def test_the_crowns_far_side_hides_its_tip():
    """From behind the bore and below, the wall opposite stands before the tip's inner edge."""
    needle = Needle(2 * R, LENGTH, SHARP["franseen"])
    over = (-60.0, 5.0, -40.0)
    behind = (-60.0, 0.0, 60.0)
    assert not apex_is_hidden(needle, looked_at_from(over))
    assert apex_is_hidden(needle, looked_at_from(behind))


def test_a_bent_shaft_hides_its_own_tip():
    """Half a turn: the hub comes round, and from beyond it the tip is behind the shaft."""
    needle = Needle(2.0, math.pi * 40, Cone(5), 40.0)
    assert apex_is_hidden(needle, looked_at_from((200.0, 0.0, 0.5)))
    assert not apex_is_hidden(needle, looked_at_from((-200.0, 0.0, 0.5)))
    assert not apex_is_hidden(needle, looked_at_from((200.0, 20.0, 0.5)))


SLIGHTLY = [
    (Cone(5), Cone(5, 1e-3)),
    (Bevel(20), Bevel(20, 1e-3)),
    (Lancet(), Lancet(tip_radius_mm=1e-3)),
    (BackBevel(), BackBevel(tip_radius_mm=1e-3)),
    (Trocar(), Trocar(tip_radius_mm=1e-3)),
    (Diamond(), Diamond(tip_radius_mm=1e-3)),
    (Franseen(), Franseen(tip_radius_mm=1e-3)),
    (Blunt(), Blunt(1e-3)),
]


@pytest.mark.parametrize(("sharp", "rounded"), SLIGHTLY)
@pytest.mark.parametrize("rho", [None, pytest.param(RHO, marks=pytest.mark.slow)])
def test_a_micrometre_of_rounding_hides_nothing(sharp, rounded, rho):
    a, b = (Needle(2 * R, LENGTH, tip, rho) for tip in (sharp, rounded))
    views = [looked_at_from(c) for c in centres(30, 8)]
    same = [apex_is_hidden(a, v) == apex_is_hidden(b, v) for v in views]
    assert np.mean(same) >= 28 / 30  # grazing views aside


@pytest.mark.parametrize(
    "tip",
    [Cone(5, 0.2), Bevel(30, 0.1), Lancet(tip_radius_mm=0.1), Trocar(20, 0.3), Diamond(40, 0.2)],
)
@pytest.mark.parametrize("axis", [(0, -1, 0), (0.3, -1, 0.4), (-0.2, -1, -0.7)])
def test_a_rounded_tips_foremost_point_in_the_image_is_its_balls(tip, axis):
    """Oracle: a net over the ball at the tip, refined where it is foremost; to a ten-thousandth px.

    Here the foremost ball is the tip's own: its centre is r behind the apex.
    """
    needle = Needle(2 * R, 150.0, tip)
    T = needle.pose((3, 10, 170), axis, 25)
    backward = projected_axis(needle, T, CAMERA)
    r = tip.tip_radius_mm
    centre = needle.apex + np.array([0, 0, r])
    middle, width = np.array([math.pi, 0.0]), math.pi
    for _ in range(12):
        grid = np.linspace(-width, width, 41)
        polar, turn = (m + g for m, g in zip(middle, np.meshgrid(grid, grid), strict=True))
        # About x, so that the poles of the net are out of the way.
        d = np.stack(
            [np.sin(turn), np.cos(turn) * np.sin(polar), np.cos(turn) * np.cos(polar)], axis=-1
        )
        pixels = CAMERA.project(T.apply(centre + r * d))
        best = np.unravel_index(np.argmin(pixels @ backward), polar.shape)
        middle, width = np.array([polar[best], turn[best]]), width / 8
    found = silhouette_tip(needle, T, CAMERA)
    if isinstance(tip, Cone | Trocar | Diamond):
        np.testing.assert_allclose(found, pixels[best], rtol=0, atol=1e-4)
    # Elsewhere another ball may be further forward, never less so.
    assert found @ backward <= pixels[best] @ backward + 1e-9
