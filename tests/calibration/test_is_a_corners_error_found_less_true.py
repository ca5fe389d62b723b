from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles.stereo_boards import photograph

from simtip.calibrate import View
from simtip.calibration_images import Pair, corner_error, read_board_truth
from simtip.errors import InputError
from simtip.target import CircleGrid, Sighting, parse_target

TARGET = parse_target("chessboard:6x5:6")


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    folder = tmp_path_factory.mktemp("truth")
    photograph(folder, tilts=((20, 40),))
    return read_board_truth(folder / "truth.json")


def seen(pixels, ids=None):
    return Sighting(np.arange(len(pixels)) if ids is None else ids, pixels)


def summary(left, right, truth, target=TARGET):
    pair = Pair("01", Path("elsewhere/left_01.png"), Path("elsewhere/right_01.png"))
    return corner_error([View("01", left, right)], [pair], truth, target).to_dict()


def test_bias_has_the_sign_of_found_less_true_and_each_camera_its_own(truth):
    left, right = (truth.pixels[f"{side}_01.png"] for side in ("left", "right"))
    found = summary(seen(left + np.array([0.25, 0])), seen(right - np.array([0, 0.5])), truth)
    assert found["left"]["bias"] == pytest.approx([0.25, 0])
    assert found["right"]["bias"] == pytest.approx([0, -0.5])
    assert found["left"]["sd"] == pytest.approx([0, 0], abs=1e-12)
    assert found["left"]["max"] == pytest.approx(0.25)
    assert found["bias"] == pytest.approx([0.125, -0.25])


def test_points_are_compared_by_their_numbers(truth):
    left, right = (truth.pixels[f"{side}_01.png"] for side in ("left", "right"))
    few = np.array([3, 7, 29])
    found = summary(seen(left[few], few), seen(right), truth)
    assert found["left"] == {"points": 3, "bias": [0, 0], "sd": [0, 0], "rms": 0, "max": 0}


def test_a_reading_from_the_other_end_counts_as_the_same_where_none_can_tell(truth):
    left, right = (truth.pixels[f"{side}_01.png"] for side in ("left", "right"))
    turned = seen(left[::-1])
    assert summary(turned, seen(right), truth)["left"]["max"] > 50
    grid = CircleGrid(6, 5, 6.0, 3.0)
    assert summary(turned, seen(right), truth, grid)["left"]["max"] == 0


def test_a_file_that_the_truth_does_not_know_is_named(truth):
    with pytest.raises(InputError, match=r"says nothing of left_09\.png"):
        truth.of(Path("left_09.png"))
