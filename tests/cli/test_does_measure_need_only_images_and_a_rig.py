"""`measure` on image files: what `run` measured, from any format that kept the pixels.

The detected pixels are equal to the bit. The point is so to rounding: the rig file holds OpenCV's
pose, the inverse of simtip's, and inverting twice moves the last digits.
"""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from command_line import MEASURE

SETTINGS = ("--set", "min_area_px=200", "--json")


@pytest.fixture
def measured(ran, ask, tmp_path):
    """Save both images again in another way and measure them."""

    def again(suffix, change=lambda image: image, *, more=(), parameters=()):
        files = []
        for side in ("left", "right"):
            image = cv2.imread(str(ran.folder / f"{side}.png"), cv2.IMREAD_UNCHANGED)
            files.append(str(tmp_path / f"{side}.{suffix}"))
            assert cv2.imwrite(files[-1], change(image), list(parameters))
        rig = str(ran.folder / "rig_true.yaml")
        answer = ask("measure", "--rig", rig, *files, *SETTINGS, *more)
        assert (answer.code, answer.err) == (0, "")
        return json.loads(answer.out)

    return again


def to_16_bit(image):
    return image.astype(np.uint16) * 257


def to_gray(image):
    """The weighted average of BT.601, with another rounding than simtip's."""
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


LOSSLESS = {
    "png": ("png", lambda image: image),
    "16-bit png": ("png", to_16_bit),
    "tiff": ("tiff", lambda image: image),
    "16-bit tiff": ("tiff", to_16_bit),
    "bmp": ("bmp", lambda image: image),
    "png with alpha": ("png", lambda image: cv2.cvtColor(image, cv2.COLOR_BGR2BGRA)),
}


@pytest.mark.parametrize(("suffix", "change"), LOSSLESS.values(), ids=LOSSLESS)
def test_a_lossless_file_gives_the_same_tip(suffix, change, measured, ran):
    result = measured(suffix, change)
    assert result["tip_detected_px"] == ran.printed["tip_detected_px"]
    for key in ("tip_measured_mm", "epipolar_distance_px", "ray_gap_mm"):
        assert result[key] == pytest.approx(ran.printed[key], abs=1e-10)
    assert result["status"] == "ok"


def test_the_folders_own_images_give_the_same(ask, ran):
    files = [str(ran.folder / name) for name in ("rig_true.yaml", "left.png", "right.png")]
    result = json.loads(ask("measure", "--rig", *files, *SETTINGS).out)
    assert result["tip_measured_mm"] == pytest.approx(ran.printed["tip_measured_mm"], abs=1e-10)
    assert [result[key] for key in ("rig", "left", "right")] == files


@pytest.mark.parametrize("suffix", ["png", "tiff", "bmp"])
def test_gray_is_as_good_as_colour(suffix, measured, ran):
    gray, colour = measured(suffix, to_gray), ran.printed
    for side in ("left", "right"):
        away = np.subtract(gray["tip_detected_px"][side], colour["tip_detected_px"][side])
        assert np.abs(away).max() <= 1
    assert (
        measured("png", lambda image: to_16_bit(to_gray(image)))
        | {key: gray[key] for key in ("left", "right", "timings_s")}
        == gray
    )


def test_jpeg_is_close(measured, ran):
    result = measured("jpg", parameters=(cv2.IMWRITE_JPEG_QUALITY, 95))
    away = np.subtract(result["tip_measured_mm"], ran.printed["tip_measured_mm"])
    assert np.linalg.norm(away) < 0.5


def test_channels_are_not_swapped(measured):
    """The detector sees R, G, B in this order: with all weight on red, only red counts."""

    def only_red(image):
        return image * np.array([0, 0, 1], np.uint8)  # OpenCV writes BGR

    red = measured("png", only_red, more=("--set", "weights=1,0,0"))
    assert red["status"] == "ok"
    blue = measured("png", only_red, more=("--set", "weights=0,0,1"))
    assert blue["status"] == "left_everything_darker_than_threshold"


def test_every_promised_key_has_its_type_and_truth_has_none(measured):
    result = measured("png")
    assert isinstance(result["detector"], str)
    assert isinstance(result["status"], str)
    assert [type(x) for x in result["tip_measured_mm"]] == [float] * 3
    assert {k: len(v) for k, v in result["tip_detected_px"].items()} == {"left": 2, "right": 2}
    assert type(result["epipolar_distance_px"]) is float
    assert set(result["timings_s"]) == {"detect", "match", "triangulate"}
    assert not {"tip_true_mm", "tip_true_px", "error_mm", "seed", "backend"} & set(result)


@pytest.mark.parametrize("method", ["svd", "midpoint", "optimal"])
def test_every_method_gives_nearly_the_same_point(method, measured, ran):
    result = measured("png", more=("--method", method))
    away = np.subtract(result["tip_measured_mm"], ran.printed["tip_measured_mm"])
    assert np.linalg.norm(away) < 0.05
    # Rays that pass each other by 0.03 mm do not meet anywhere: each method has its own point.
    assert (np.linalg.norm(away) < 1e-10) == (method == "svd")


def test_no_tip_is_a_result_with_its_reason(measured):
    result = measured("png", more=("--set", "min_area_px=4500"))
    assert result["status"] == "left_no_component_large_enough"
    assert "4500" in result["reason"]
    assert result["tip_measured_mm"] is None
    assert result["epipolar_distance_px"] is None
    assert result["tip_detected_px"] == {"left": None, "right": None}
    assert result["timings_s"]["triangulate"] == 0


def test_tips_off_their_epipolar_lines_are_a_result_with_its_reason(measured):
    result = measured("png", more=("--max-distance", "0.001"))
    assert result["status"].startswith("off_epipolar_line")
    assert "0.001" in result["reason"]
    assert result["tip_measured_mm"] is None
    assert result["epipolar_distance_px"] > 0.001


@pytest.mark.usefixtures("bench")
def test_the_table_says_why_there_is_no_tip(ask):
    answer = ask(*MEASURE, "--set", "min_area_px=9000")
    assert (answer.code, answer.err) == (0, "")
    assert "left_no_component_large_enough" in answer.out
