"""Is every number of truth.json what OpenCV makes of the poses and of the plate as stated?"""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from boards.board_scenes import changed, lens

from simtip.boards import BoardSet, plan_boards
from simtip.boards_folder import digest
from simtip.geometry import Pose
from simtip.rig_file import rig_text
from simtip.rig_file.own_json import rig_from_json
from simtip.yaml_file import Document

LEFT = {"distortion": [-0.12, 0.05, 0.001, -0.0008, 0.01]}
RIGHT = {"distortion": [-0.10, 0.04, -0.0007, 0.0012, -0.02]}
BOW, SCALE, MARGIN = 1.5, (1.01, 0.98), 4.0


@pytest.fixture(scope="module")
def boards(scene) -> BoardSet:
    plate = {"bow_mm": BOW, "print_scale": SCALE, "margin_mm": MARGIN}
    target = {"target": "charuco:8x6:7:5", "plate": plate, "views": 4}
    return plan_boards(changed(lens(scene, LEFT, RIGHT), boards=target), seed=9)


@pytest.fixture(scope="module")
def truth(boards) -> dict:
    return json.loads(json.dumps(boards.truth(), allow_nan=False))


def printed() -> np.ndarray:
    """Corners of 7 mm squares from (0, 0), scaled, on a paraboloid over the plate: by hand."""
    nominal = np.array([[7.0 * i, 7.0 * j] for j in range(5) for i in range(7)])
    at = nominal * SCALE
    low, high = np.array([-7.0, -7.0]) * SCALE - MARGIN, np.array([49.0, 35.0]) * SCALE + MARGIN
    off = at - (low + high) / 2
    z = BOW * (off**2).sum(axis=1) / (((high - low) / 2) ** 2).sum()
    return np.column_stack([at, z])


def test_points_are_projected_as_opencv_does(scene, truth):
    np.testing.assert_allclose(truth["plate"]["points_mm"], printed(), atol=1e-12)
    rig = scene.rig.rig()
    assert len(truth["views"]) == 4
    for view in truth["views"]:
        world = printed() @ np.array(view["R"]).T + view["t_mm"]
        right = rig.T_lr.inverse()
        for side, camera, pose, bent in (
            ("left", rig.left, Pose.identity(), LEFT), ("right", rig.right, right, RIGHT),
        ):  # fmt: skip
            expected = cv2.projectPoints(
                world, cv2.Rodrigues(pose.R)[0], pose.t, camera.K, np.array(bent["distortion"])
            )[0].reshape(-1, 2)
            np.testing.assert_allclose(view[side]["points_px"], expected, atol=1e-7)
            assert view[side]["visible"] == [True] * len(expected)


def test_names_and_sizes_are_the_images(truth, boards):
    assert [view["left"]["file"] for view in truth["views"]] == [
        f"left_0{k}.png" for k in (1, 2, 3, 4)
    ]
    assert truth["views"][2]["right"]["file"] == "right_03.png"
    assert truth["views"][2]["name"] == boards.name(2) == "03"
    assert truth["image_size"] == {"left": [2048, 1436], "right": [2048, 1436]}
    many = BoardSet(boards.spec, 1, boards.plate, boards.poses * 25)
    assert (many.name(0), many.name(99)) == ("001", "100")


def test_a_point_off_the_image_is_not_visible(boards):
    """Poses that `simtip boards` would not choose: one board half out, one behind the cameras."""
    aside = Pose(np.eye(3), np.array([-100.0, -20.0, 170.0]))
    behind = Pose(np.eye(3), np.array([0.0, 0.0, -170.0]))
    seen = BoardSet(boards.spec, 1, boards.plate, (aside, behind)).truth()["views"]
    px, visible = np.array(seen[0]["left"]["points_px"]), np.array(seen[0]["left"]["visible"])
    inside = (px >= -0.5).all(axis=1) & (px < [2047.5, 1435.5]).all(axis=1)
    np.testing.assert_array_equal(visible, inside)
    assert 0 < visible.sum() < len(visible)
    assert not any(seen[1]["left"]["visible"])


def test_the_rig_reads_back(boards):
    """Under the key that the folder adds to the truth."""
    rig = boards.spec.rig.rig()
    again = rig_from_json(Document("truth.json", json.loads(rig_text(rig, "json")), {}))
    for a, b in ((again.left, rig.left), (again.right, rig.right)):
        np.testing.assert_allclose(a.K, b.K, rtol=1e-15)
        assert (a.size, a.distortion) == (b.size, b.distortion)
    np.testing.assert_allclose(again.T_lr.t, rig.T_lr.t, atol=1e-12)
    np.testing.assert_allclose(again.T_lr.R, rig.T_lr.R, atol=1e-14)


def test_the_working_volume_is_the_robots_about_the_tip(truth):
    low, high = (np.array(truth["working_volume_mm"][end]) for end in ("low", "high"))
    np.testing.assert_allclose((low + high) / 2, [-10, 20, 170])
    np.testing.assert_allclose(high - low, [28, 22, 15])


def test_the_digest_is_not_of_the_rig_that_measures(boards):
    rig = boards.spec.rig.model_copy(update={"measured": "anywhere.yaml"})
    assert digest(replace(boards, spec=boards.spec.model_copy(update={"rig": rig}))) == digest(
        boards
    )


@pytest.mark.parametrize(
    ("part", "change", "same"),
    [
        ("detect", {"threshold": 90}, True),
        ("triangulate", {"method": "midpoint"}, True),
        ("match", {"max_distance_px": 3}, True),
        ("clutter", {"level": "light"}, True),
        ("name", "another", True),
        ("sensor", {"read_noise_e": 6}, False),
        ("ambient", {"radiance_w_m2_sr": [0.004, 0.003, 0.003]}, False),
        ("boards", {"views": 3}, False),
        ("boards", {"target": "charuco:8x6:7:5.1"}, False),
        ("seed", 10, False),
    ],
)
def test_the_digest_is_of_what_decides_the_images(boards, scene, part, change, same, monkeypatch):
    """With the poses given, it is not by them that it differs."""
    monkeypatch.setattr(
        "simtip.boards.plate_poses", lambda _, __, views, ___: list(boards.poses[:views])
    )
    spec = scene.model_copy(update={"boards": boards.spec.boards})
    first = digest(plan_boards(spec, seed=9))
    assert digest(plan_boards(spec, seed=9)) == first
    other = plan_boards(changed(spec, **{part: change}), seed=change if part == "seed" else 9)
    assert (digest(other) == first) is same
