"""Is the truth of a scene the geometry that the scene states, and is nonsense refused?"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from simtip.errors import InputError
from simtip.spec import SceneSpec
from simtip.truth import scene_truth

SCENE = Path(__file__).parents[2] / "scenes" / "01_single_tip.yaml"


def scene(**needle):
    """The first scene, with other values for its needle; `background` and `rig` replace parts."""
    data = yaml.safe_load(SCENE.read_text(encoding="utf-8"))
    for part in ("background", "rig"):
        data[part].update(needle.pop(part, {}))
    data["needle"].update(needle)
    return SceneSpec.model_validate(data)


def by_opencv(spec, point):
    """Oracle: cv2.projectPoints from the file's own numbers, p_left = R p_right + t."""
    U, _, Vt = np.linalg.svd(np.array(spec.rig.R))
    R = U @ Vt
    poses = {
        "left": (np.zeros(3), np.zeros(3)),
        "right": (cv2.Rodrigues(R.T)[0], -R.T @ np.array(spec.rig.t_mm)),
    }
    pixels = {}
    for name, (rvec, tvec) in poses.items():
        c = getattr(spec.rig, name)
        K = np.array([[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]])
        uv, _ = cv2.projectPoints(
            np.array(point, dtype=float).reshape(1, 1, 3), rvec, tvec, K, None
        )
        pixels[name] = uv.reshape(2)
    return pixels


@pytest.mark.parametrize("tip_mm", [(-10, 20, 170), (5.5, -12.25, 190.125)])
@pytest.mark.parametrize(
    "tip", [{"kind": "cone", "length_mm": 5}, {"kind": "bevel", "angle_deg": 15}]
)
def test_the_tip_is_where_it_is_stated_and_projects_as_opencv_has_it(tip_mm, tip):
    spec = scene(tip_mm=tip_mm, tip=tip, roll_deg=70, axis=(0.1, -2, 0.05))
    truth = scene_truth(spec)
    np.testing.assert_allclose(truth.tip_mm, tip_mm, rtol=0, atol=1e-12)
    np.testing.assert_allclose(truth.axis, np.array((0.1, -2, 0.05)) / np.sqrt(4.0125), rtol=1e-15)
    expected = by_opencv(spec, tip_mm)
    np.testing.assert_allclose(truth.left.tip_px, expected["left"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(truth.right.tip_px, expected["right"], rtol=0, atol=1e-9)


def test_the_axis_in_each_image_leads_from_the_tip_to_a_point_up_the_needle():
    spec = scene(axis=(0.3, -1, 0.2))
    truth = scene_truth(spec)
    up = by_opencv(spec, truth.tip_mm + 30 * truth.axis)  # a pinhole keeps lines straight
    for name in ("left", "right"):
        view = getattr(truth, name)
        along = up[name] - view.tip_px
        np.testing.assert_allclose(view.axis_px, along / np.linalg.norm(along), atol=1e-9)


def test_cone_and_bevel_differ_in_what_is_foremost():
    cone, bevel = (
        scene_truth(scene(tip=tip, roll_deg=90, axis=(0, -0.4, -1), length_mm=50))
        for tip in ({"kind": "cone"}, {"kind": "bevel"})
    )
    np.testing.assert_array_equal(cone.left.silhouette_tip_px, cone.left.tip_px)
    assert np.linalg.norm(bevel.left.silhouette_tip_px - bevel.left.tip_px) > 0.5


def test_a_region_of_interest_counts_pixels_from_its_corner():
    whole = scene_truth(scene())
    left = {"width": 2048, "height": 1436, "fx": 1909.84, "fy": 1910.22, "cx": 932.97, "cy": 657.9}
    part = scene_truth(scene(rig={"left": {**left, "roi": [700, 800, 300, 200]}}))
    np.testing.assert_allclose(part.left.tip_px, whole.left.tip_px - [700, 800], atol=1e-9)
    np.testing.assert_array_equal(part.right.tip_px, whole.right.tip_px)
    assert (part.rig.left.width, part.rig.left.height) == (300, 200)
    assert part.left.tip_visible


def test_one_view_is_enough():
    """Far to the left of the left camera only the right one, turned that way, sees it."""
    truth = scene_truth(scene(tip_mm=(-110, 20, 170)))
    assert not truth.left.needle_in_view
    assert not truth.left.tip_visible
    assert truth.right.needle_in_view
    assert truth.right.tip_visible
    assert truth.left.tip_px[0] < -0.5


def test_a_tip_below_the_image_is_not_visible_while_its_needle_is():
    truth = scene_truth(scene(tip_mm=(-10, 75, 170)))
    assert truth.left.needle_in_view
    assert not truth.left.tip_visible
    assert truth.left.tip_px[1] > 1436


def test_a_tip_behind_its_own_body_is_not_visible():
    truth = scene_truth(scene(tip_mm=(0, 3, 170), axis=(0, -0.02, -1), length_mm=100))
    assert truth.left.needle_in_view
    assert not truth.left.tip_visible


def test_the_dictionary_is_plain_and_complete():
    spec = scene(tip={"kind": "bevel", "angle_deg": 15})
    truth = scene_truth(spec)
    data = truth.to_dict()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["tip_mm"] == truth.tip_mm.tolist()
    assert data["needle"]["tip"] == {"kind": "bevel", "angle_deg": 15.0, "tip_radius_mm": 0.0}
    assert data["needle"]["diameter_mm"] == 1.67
    np.testing.assert_array_equal(data["needle"]["T_wn"]["R"], truth.T_wn.R)
    np.testing.assert_array_equal(data["T_lr"]["t_mm"], spec.rig.t_mm)
    assert data["right"]["K_px"][0] == [1923.38, 0, 935.88]
    assert data["left"]["K_px"][1] == [0, 1910.22, 657.9]
    assert data["left"]["width_px"] == 2048
    for name in ("left", "right"):
        view = getattr(truth, name)
        assert data[name]["tip_px"] == view.tip_px.tolist()
        assert data[name]["silhouette_tip_px"] == view.silhouette_tip_px.tolist()
        assert data[name]["axis_px"] == view.axis_px.tolist()
        assert data[name]["tip_visible"] is True


REFUSED = {
    "tip behind the left camera": (
        {"tip_mm": (-10, 20, -5)},
        "needle.tip_mm",
        "behind the left camera, at z = -5 mm",
    ),
    "tip behind the right camera": (
        {"tip_mm": (400, 0, 20), "background": {"centre_mm": (0, 0, 900)}},
        "needle.tip_mm",
        "behind the right camera",
    ),
    "needle outside both views": (
        {"tip_mm": (0, -300, 170)},
        "needle.tip_mm",
        "outside both images",
    ),
    "needle pointing at a camera": (
        {"tip_mm": (0, 0, 170), "axis": (0, 0, 1), "length_mm": 50},
        "needle.axis",
        "in the left view the needle points straight",
    ),
    "needle behind the background": (
        {"tip_mm": (-10, 20, 300)},
        "needle.tip_mm",
        "needle is behind the background",
    ),
    "needle through the background, tip in front": (
        {"axis": (0, -1, 1)},
        "needle.axis",
        "passes through the background, by 16.",
    ),
    "needle through the background, tip behind": (
        {"tip_mm": (-10, 20, 270), "axis": (0, -1, -1)},
        "needle.tip_mm",
        "the tip is 10 mm behind it",
    ),
    "background turned away": (
        {"background": {"normal": (0, 0, 1)}},
        "background.normal",
        "both cameras are behind the background",
    ),
    "right camera behind the background": (
        {"background": {"centre_mm": (60, 0, 0), "normal": (-1, 0, 0)}},
        "background.centre_mm",
        "the right camera is behind",
    ),
    "left camera inside the needle": (
        {"tip_mm": (0, 20, 5), "diameter_mm": 40},
        "needle.tip_mm",
        "the left camera is inside the needle",
    ),
    "a normal too short to have a length": (
        {"background": {"normal": (0, 0, -1e-300)}},
        "background.normal",
        "length",
    ),
}


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_truth_is_refused_naming_the_field(case):
    changes, field, problem = REFUSED[case]
    with pytest.raises(InputError) as caught:
        scene_truth(scene(**changes))
    assert caught.value.field == field
    assert problem in caught.value.problem
    assert caught.value.remedy
    assert caught.value.file is None
    assert "\n" not in str(caught.value)


def test_a_tip_longer_than_its_needle_is_refused_by_the_scene_itself():
    with pytest.raises(ValueError, match="does not fit"):
        scene(length_mm=4)


FAMILIES = [
    {"kind": "cone", "length_mm": 4, "tip_radius_mm": 0.05},
    {"kind": "bevel", "angle_deg": 20, "tip_radius_mm": 0.03},
    {"kind": "back_bevel"},
    {"kind": "lancet", "tip_radius_mm": 0.02},
    {"kind": "trocar", "angle_deg": 15},
    {"kind": "diamond", "tip_radius_mm": 0.1},
    {"kind": "franseen"},
    {"kind": "blunt", "tip_radius_mm": 0.2},
]


@pytest.mark.parametrize("tip", FAMILIES, ids=lambda tip: tip["kind"])
@pytest.mark.parametrize(
    "bend",
    [
        {},
        pytest.param({"bend_radius_mm": 120, "bend_direction_deg": -80}, marks=pytest.mark.slow),
    ],
)
def test_every_family_has_its_tip_where_it_is_stated(tip, bend):
    spec = scene(tip=tip, roll_deg=50, axis=(0.1, -1, 0.1), **bend)
    truth = scene_truth(spec)
    expected = by_opencv(spec, (-10, 20, 170))
    np.testing.assert_allclose(truth.left.tip_px, expected["left"], rtol=0, atol=1e-9)
    up = by_opencv(spec, truth.tip_mm + 1e-3 * truth.axis)["left"] - truth.left.tip_px
    np.testing.assert_allclose(truth.left.axis_px, up / np.linalg.norm(up), atol=1e-4)
    # Nothing lies further forward, and the foremost point is near the tip: a needle's width.
    ahead = (truth.left.silhouette_tip_px - truth.left.tip_px) @ truth.left.axis_px
    assert -10 < ahead <= 0
    assert np.linalg.norm(truth.left.silhouette_tip_px - truth.left.tip_px) < 20
    data = truth.to_dict()["needle"]
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["tip"]["kind"] == tip["kind"]
    assert data["tip"]["tip_radius_mm"] == tip.get("tip_radius_mm", 0)
    assert data["bend_radius_mm"] == bend.get("bend_radius_mm")


def test_the_truth_says_where_the_crowns_other_points_are():
    """At a Franseen's bore, 120 degrees apart about the axis: sqrt(3) bore radii from the tip."""
    needle = scene_truth(scene(tip={"kind": "franseen"})).to_dict()["needle"]
    others = np.array(needle["equally_foremost_mm"])
    assert others.shape == (2, 3)
    np.testing.assert_allclose(others[:, 1], 20, atol=1e-12)  # the axis is vertical
    away = np.linalg.norm(others - [-10, 20, 170], axis=1)
    np.testing.assert_allclose(away, np.sqrt(3) * 0.72 * 0.835, rtol=1e-12)
    assert scene_truth(scene()).to_dict()["needle"]["equally_foremost_mm"] == []


@pytest.mark.parametrize(
    ("needle", "message"),
    [
        ({"tip": {"kind": "cone", "tip_radius_mm": 0.9}}, "tip_radius_mm has to be 0 or between"),
        ({"tip": {"kind": "lancet", "side_angle_deg": 5}}, "side_angle_deg has to be above"),
        ({"bend_radius_mm": 20}, "bend_radius_mm has to be at least 47.7465"),
        ({"tip": {"kind": "franseen"}, "length_mm": 8}, "length_mm has to be above"),
    ],
)
def test_an_impossible_needle_names_its_field(needle, message):
    with pytest.raises(ValueError, match=message):
        scene(**needle)
