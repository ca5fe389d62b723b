"""What cannot be calibrated from is named in one line, with exit code 2, and nothing is written."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from oracles.stereo_boards import TARGET, photograph

pytestmark = pytest.mark.slow


def change(file, how):
    assert cv2.imwrite(str(file), how(cv2.imread(str(file), cv2.IMREAD_UNCHANGED)))


def test_a_folder_that_is_not_there(ask, complaint, tmp_path):
    assert "nowhere: is no folder" in complaint(ask(tmp_path / "nowhere", "--target", TARGET))


def test_one_camera_only(some, ask, complaint):
    folder = some(1, 2, 3)
    for file in folder.glob("right*"):
        file.unlink()
    assert "3 images, but none of the right camera" in complaint(ask(folder, "--target", TARGET))


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("chessbord:6x5:6", "--target: no family"),
        ("chessboard:6x5", "--target: "),
        ("chessboard:6by5:6", "--target: '6by5'"),
        ("chessboard:6x5:-6", "--target: "),
    ],
)
def test_a_target_said_wrongly(target, said, boards, ask, complaint):
    assert complaint(ask(boards, "--target", target)).startswith(said)


def test_no_target(boards, ask, complaint):
    assert "--target" in complaint(ask(boards))


def test_a_model_that_is_none(boards, ask, complaint):
    line = complaint(ask(boards, "--target", TARGET, "--model", "fisheye"))
    assert line.startswith("--model: ")
    assert "rational" in line


def test_a_file_that_is_cut_short(some, ask, complaint):
    folder = some(1, 2, 3)
    file = folder / "right_02.png"
    file.write_bytes(file.read_bytes()[:3000])
    line = complaint(ask(folder, "--target", TARGET))
    assert line.startswith(f"{file}: is cut short")


def test_images_of_two_sizes(some, ask, complaint):
    folder = some(1, 2, 3)
    change(folder / "left_02.png", lambda image: image[:-8])
    line = complaint(ask(folder, "--target", TARGET))
    assert line.startswith(f"{folder / 'left_02.png'}: is 320 x 232 px, 2 of the 3 left images are")


def test_too_few_views(some, ask, complaint):
    line = complaint(ask(some(1, 2), "--target", TARGET))
    assert "2 of 2 views, 3 are needed" in line


def test_a_board_of_another_size(some, ask, complaint):
    line = complaint(ask(some(1, 2, 3), "--target", "chessboard:8x5:6"))
    assert line.startswith("--target: chessboard:8x5:6 was found by both cameras in 0 of 3 views")
    assert "6x5" in line


def test_left_and_right_swapped(some, ask, complaint):
    folder = some(1, 2, 3, 4)
    line = complaint(ask(f"{folder}/right*", f"{folder}/left*", "--target", TARGET))
    assert "swapped" in line
    assert line.endswith("exchange left and right, or unmirror them if both are mirrored")


def test_left_and_right_of_different_instants(some, ask, complaint):
    folder = some(1, 2, 3, 4)
    names = [folder / f"right_{k:02d}.png" for k in (1, 2, 3, 4)]
    contents = [name.read_bytes() for name in names]
    for name, content in zip(names, contents[1:] + contents[:1], strict=True):
        name.write_bytes(content)
    line = complaint(ask(folder, "--target", TARGET))
    assert "agree about the board in only" in line
    assert "same instant" in line


@pytest.mark.parametrize("sides", [("left", "right"), ("right",)])
def test_mirrored_images(sides, some, ask, complaint):
    folder = some(1, 2, 3, 4)
    for side in sides:
        for file in folder.glob(f"{side}*"):
            change(file, lambda image: np.ascontiguousarray(image[:, ::-1]))
    line = complaint(ask(folder, "--target", TARGET))
    assert str(folder) in line or "--target" in line


def test_boards_all_in_parallel_planes(tmp_path, ask, complaint):
    folder = tmp_path / "flat"
    folder.mkdir()
    photograph(folder, tilts=((0, 0),) * 4)
    line = complaint(ask(folder, "--target", TARGET))
    assert line.startswith(f"{folder}: views: all boards seen by the left camera are parallel")
    assert "tilt the board" in line


@pytest.mark.parametrize("option", ["-o", "--plots"])
def test_what_is_there_is_not_overwritten(option, boards, ask, complaint, tmp_path):
    out = tmp_path / "rig.yaml"
    out.write_text("mine")
    assert "exists" in complaint(ask(boards, "--target", TARGET, option, out))
    assert out.read_text() == "mine"


def test_nothing_is_written_when_it_fails(some, ask, complaint, tmp_path):
    out, plots = tmp_path / "rig.yaml", tmp_path / "plots"
    complaint(ask(some(1, 2), "--target", TARGET, "-o", out, "--plots", plots))
    assert not out.exists()
    assert not plots.exists()


def spoilt(path):
    def spoil(truth):
        *parents, last = path
        value = truth
        for key in parents:
            value = value[key]
        del value[last]

    return spoil


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (spoilt(("target",)), "target: is missing"),
        (spoilt(("rig", "K_left")), "K_left: is missing"),
        (spoilt(("plate",)), "plate: is missing"),
        (spoilt(("working_volume_mm", "low")), "working_volume_mm.low: is not 3 finite numbers"),
        (spoilt(("views", 1, "left")), "views[1].left: is missing"),
        (spoilt(("views", 1, "left", "file")), "views[1].left.file: is missing"),
        (spoilt(("views", 2, "right", "points_px", 4)), "views[2].right.points_px: is not 30 x 2"),
        (spoilt(("views", 1)), "says nothing of left_02.png"),
        (lambda truth: truth.update(target="chessboard:7x5:6"), "views[0].left.points_px"),
        (lambda truth: truth.update(views="none"), "views: is no list"),
        (lambda truth: truth["rig"].update(version=2), "version: "),
    ],
)
def test_a_truth_that_is_none(spoil, said, boards, ask, complaint, tmp_path):
    truth = json.loads((boards / "truth.json").read_text())
    spoil(truth)
    file = tmp_path / "truth.json"
    file.write_text(json.dumps(truth))
    line = complaint(ask(boards, "--target", TARGET, "--truth", file))
    assert line.startswith(str(file))
    assert said in line


def test_a_truth_that_is_no_json(boards, ask, complaint, tmp_path):
    file = tmp_path / "truth.json"
    file.write_text("views: 3")
    assert complaint(ask(boards, "--target", TARGET, "--truth", file)).startswith(
        f"{file}: is cut short or no JSON"
    )


def test_another_target_than_the_truths(boards, ask, complaint):
    line = complaint(ask(boards, "--target", "circles:6x5:6:3", "--truth", boards / "truth.json"))
    assert line.startswith("--target: is circles:6x5:6:3, and ")
