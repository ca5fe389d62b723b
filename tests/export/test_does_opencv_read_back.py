"""What `cv2.FileStorage` finds in an export, and whether it fits together."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from export.exported import exported


def storage(file: Path) -> cv2.FileStorage:
    opened = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
    assert opened.isOpened()
    return opened


def texts(file: Path, name: str | None = None) -> list[str]:
    """Read a sequence of texts: a node, or the first one."""
    opened = storage(file)
    node = opened.getFirstTopLevelNode() if name is None else opened.getNode(name)
    assert node.isSeq()
    return [node.at(k).string() for k in range(node.size())]


def matrix(file: Path, name: str) -> np.ndarray:
    opened = storage(file)
    return opened.getNode(name).mat()


@pytest.fixture(scope="module")
def out(plain, bevel, tmp_path_factory) -> Path:
    return exported(tmp_path_factory.mktemp("opencv") / "out", "opencv", plain, bevel)


@pytest.fixture(scope="module")
def of_boards(boards, tmp_path_factory) -> Path:
    return exported(tmp_path_factory.mktemp("opencv") / "boards", "opencv", boards)


def test_the_list_is_as_opencvs_calibration_samples_read_it(out):
    """The first node, a sequence of names, left and right in turns (`stereo_calib.cpp`)."""
    names = texts(out / "image_list.xml")
    assert names == [f"{side}_00000{k}.png" for k in (0, 1) for side in ("left", "right")]
    assert all((out / name).is_file() for name in names)


def test_images_are_the_rendered_ones_bit_for_bit(out, plain, bevel):
    for number, source in enumerate((plain, bevel)):
        for side in ("left", "right"):
            made, taken = (
                cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
                for file in (out / f"{side}_{number:06d}.png", source / f"{side}.png")
            )
            assert made.dtype == taken.dtype
            assert np.array_equal(made, taken)


def test_the_rig_is_the_true_one_and_is_written_once(out, plain):
    rig, true = storage(out / "rig.yaml"), storage(plain / "rig_true.yaml")
    for name in ("M1", "D1", "M2", "D2", "R", "T"):
        assert np.array_equal(rig.getNode(name).mat(), true.getNode(name).mat())
    assert texts(out / "truth.yaml", "rigs") == ["rig.yaml", "rig.yaml"]
    assert len(list(out.glob("rig*.yaml"))) == 1


def test_another_rig_is_another_file(plain, bent_lens, tmp_path):
    out = exported(tmp_path / "out", "opencv", plain, bent_lens, plain)
    names = texts(out / "truth.yaml", "rigs")
    assert names == ["rig.yaml", "rig_2.yaml", "rig.yaml"]
    assert matrix(out / "rig_2.yaml", "D1").ravel()[0] == -0.12


def test_true_tips_triangulate_to_the_true_place(out, plain, bevel):
    truth, rig = storage(out / "truth.yaml"), storage(out / "rig.yaml")
    R, T = rig.getNode("R").mat(), rig.getNode("T").mat()
    P1 = rig.getNode("M1").mat() @ np.eye(3, 4)
    P2 = rig.getNode("M2").mat() @ np.hstack([R, T])
    pixels = [truth.getNode(name).mat().T for name in ("tips1", "tips2")]
    found = cv2.triangulatePoints(P1, P2, *pixels)
    places = truth.getNode("tips_mm").mat()
    assert np.allclose((found[:3] / found[3]).T, places, atol=1e-6)
    for row, source in zip(places, (plain, bevel), strict=True):
        told = json.loads((source / "truth.json").read_text())
        assert row.tolist() == told["tip_mm"]
    assert np.allclose(truth.getNode("axes").mat(), [[0, -1, 0]] * 2)


def test_corners_are_the_projected_points_of_the_board(of_boards):
    truth, rig = storage(of_boards / "truth.yaml"), storage(of_boards / "rig.yaml")
    points = truth.getNode("object_points_mm").mat()
    corners = [truth.getNode(name).mat() for name in ("corners1", "corners2")]
    turns, shifts = truth.getNode("R").mat(), truth.getNode("t_mm").mat()
    R, T = rig.getNode("R").mat(), rig.getNode("T").mat().ravel()
    assert points.shape == (9, 3)
    assert corners[0].shape == (3, 9, 2)
    for k in range(3):
        in_left = points @ np.reshape(turns[k], (3, 3)).T + shifts[k]
        for number, seen in ((1, in_left), (2, in_left @ R.T + T)):
            K, D = rig.getNode(f"M{number}").mat(), rig.getNode(f"D{number}").mat()
            pixels, _ = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), K, D)
            assert np.allclose(corners[number - 1][k], pixels.reshape(-1, 2), atol=1e-9)
    assert (truth.getNode("visible1").mat() == 1).all()


def test_a_calibration_of_the_true_corners_gives_the_rig_back(of_boards):
    """As a user of OpenCV would: three views of a small board suffice for the pose alone."""
    truth, rig = storage(of_boards / "truth.yaml"), storage(of_boards / "rig.yaml")
    points = truth.getNode("object_points_mm").mat().astype(np.float32)
    left, right = (
        [corners.astype(np.float32) for corners in truth.getNode(name).mat()]
        for name in ("corners1", "corners2")
    )
    given = [rig.getNode(name).mat() for name in ("M1", "D1", "M2", "D2")]
    rms, *_, R, T, _, _ = cv2.stereoCalibrate(
        [points] * 3, left, right, *given, (140, 140), flags=cv2.CALIB_FIX_INTRINSIC
    )
    assert rms < 1e-3
    assert np.allclose(R, rig.getNode("R").mat(), atol=1e-4)
    assert np.allclose(T, rig.getNode("T").mat(), atol=2e-2)
