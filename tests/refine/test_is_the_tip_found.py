"""A needle of known shape, drawn by another program: is its tip where it says it is?"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from ray_cast_needle import RoundNeedle, pair

from simtip.camera import StereoRig
from simtip.geometry import Pose
from simtip.refine import RefineStatus, Solid, named, refine
from simtip.refine.place import roll_deg

TIP = [-10, 20, 170]
CONE = RoundNeedle(0.835, cone=5.0)
BEVEL = RoundNeedle(0.835, bevel_deg=20.0)
CASES = {
    "cone": (CONE, {"room": (70, 200, 40)}),
    "bevel seen by the left camera": (BEVEL, {"roll_deg": 70.0}),
    "bevel that looks away": (BEVEL, {"roll_deg": 200.0}),
    "cone askew": (CONE, {"axis": (0.4, -1, 0.1), "room": (150, 330, 40)}),
    "cone that points up": (CONE, {"axis": (0.1, 1, 0.05), "room": (80, 60, 330)}),
}
QUICK = ("cone",)


def check(drawn, seed=3):
    found = refine(*drawn.noisy(seed), drawn.rig, named(drawn.needle.name))
    assert found.ok, found.reason
    off = found.tip_mm - drawn.tip_mm
    # 1 um, five times the paper's bound, is 0.01 px; what is left is noise, and claimed.
    assert np.linalg.norm(off) < 0.004
    assert np.sqrt(off @ np.linalg.inv(found.covariance_mm2) @ off) < 4.5
    assert found.axis @ drawn.T_wn.R[:, 2] > np.cos(5e-4)
    assert found.misfit.max() < 1.6
    for tip, camera, T_cw in (
        (found.tips_px[0], drawn.rig.left, Pose.identity()),
        (found.tips_px[1], drawn.rig.right, drawn.rig.T_lr.inverse()),
    ):
        np.testing.assert_allclose(tip, camera.project(T_cw.apply(found.tip_mm)), atol=1e-9)
    if drawn.needle.bevel_deg:
        turn = found.roll_deg - roll_deg(drawn.T_wn)
        assert abs((turn + 180) % 360 - 180) < 0.3
    else:
        assert found.roll_deg is None


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CASES],
)
def test_the_tip_is_found_to_micrometres(table_1, name):
    needle, where = CASES[name]
    check(pair(table_1, needle, TIP, **where))


@pytest.mark.slow
def test_lenses_that_distort_make_no_difference(distorted):
    check(pair(distorted, CONE, TIP))


@pytest.mark.slow
@pytest.mark.parametrize(("quality", "most_mm"), [(40, 0.05), (60, 0.01), (90, 0.003)])
def test_lossy_storage_moves_it_by_little(table_1, quality, most_mm):
    """Flat parts show no noise then, and edges ripple: the needle is no misfit for that.

    Ripples are alike over a block of 8 x 8 px: of the strongest compression too little is claimed.
    """
    drawn = pair(table_1, CONE, TIP)
    stored = [
        cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], 0)
        for image in drawn.noisy(3)
    ]
    found = refine(*stored, drawn.rig, named(CONE.name))
    assert found.ok, found.reason
    off = found.tip_mm - drawn.tip_mm
    assert np.linalg.norm(off) < most_mm
    if quality > 40:
        assert np.sqrt(off @ np.linalg.inv(found.covariance_mm2) @ off) < 6


@pytest.mark.slow
def test_a_needle_of_another_shape_is_refused_or_seen_in_the_misfit(table_1):
    drawn = pair(table_1, CONE, TIP)
    found = refine(*drawn.noisy(3), drawn.rig, named(BEVEL.name))
    assert not found.ok or found.misfit.max() > 3


def test_pictures_without_a_needle_are_a_reason(table_1):
    blank = np.full((200, 160), 180, np.uint8)
    left, right = (c.cropped(700, 700, 160, 200) for c in (table_1.left, table_1.right))
    found = refine(blank, blank, replace(table_1, left=left, right=right), named("cone:1.67:5"))
    assert found.status is RefineStatus.LEFT_NOT_FOUND
    assert found.tip_mm is None
    assert "edges" in found.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_along_the_baseline(table_1, seed):
    """There the planes of both axes are one, and say nothing of the depth."""
    drawn = pair(table_1, CONE, TIP, axis=(1, 0.03, 0.2), room=(300, 60, 60))
    found = refine(*drawn.noisy(seed), drawn.rig, named(CONE.name))
    assert found.ok, found.reason
    assert np.linalg.norm(found.tip_mm - drawn.tip_mm) < 0.03


@pytest.mark.slow
def test_a_rig_that_makes_no_line_of_the_axes_is_a_reason(table_1):
    drawn = pair(table_1, CONE, TIP)
    one = drawn.rig.left
    # The same picture twice, from one place.
    rig = StereoRig(one, one, Pose(np.eye(3), np.array([0.0, 0.0, 1.0])))
    left, _ = drawn.noisy(1)
    found = refine(left, left, rig, named(CONE.name))
    assert found.status is RefineStatus.NO_START


def test_the_solid_is_what_is_drawn():
    # Guards the tests: the text form and the ray caster mean the same needle.
    for needle in (CONE, BEVEL):
        solid = named(needle.name)
        assert isinstance(solid, Solid)
        np.testing.assert_allclose(solid.apex, needle.apex, atol=1e-12)
        o, d = np.array([-0.3, -30.0, 2.4]), np.array([[0.0, 1.0, 1e-4]])
        assert needle.hits(o, d)[0][0] == (needle is CONE)
