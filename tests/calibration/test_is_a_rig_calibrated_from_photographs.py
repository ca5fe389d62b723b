"""`simtip calibrate` on a folder of photographs with known truth, made without simtip."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from oracles import stereo_boards
from oracles.stereo_boards import BASELINE, LEFT, RIGHT, SIZE, TARGET, R, T

from simtip.rig_file import read_rig

pytestmark = pytest.mark.slow

SHAPES = {
    "K_left": (3, 3),
    "D_left": (5,),
    "K_right": (3, 3),
    "D_right": (5,),
    "R": (3, 3),
    "T_mm": (3,),
}


def test_every_promised_key_is_there(calibrated):
    found = calibrated.printed
    assert set(found["rms_px"]) == {"left", "right", "stereo"}
    assert found["views_used"] == [f"{k:02d}" for k in range(1, 9)]
    assert found["views_rejected"] == []
    for key, shape in SHAPES.items():
        assert np.shape(found[key]) == np.shape(found["std"][key]) == shape
    assert np.shape(found["F"]) == (3, 3)
    assert isinstance(found["baseline_mm"], float)
    assert isinstance(found["std"]["baseline_mm"], float)
    assert {"mean", "max"} <= set(found["epipolar_px"])
    assert {"mean", "max"} <= set(found["error_at_needle_mm"])
    assert found["image_size"] == {"left": list(SIZE), "right": list(SIZE)}
    assert found["target"] == TARGET


def test_the_rig_is_the_true_one(calibrated):
    found = calibrated.printed
    assert found["baseline_mm"] == pytest.approx(BASELINE, abs=0.05)
    assert np.linalg.norm(np.subtract(found["T_mm"], T)) < 0.15
    turn = cv2.Rodrigues(np.array(found["R"]) @ R.T)[0]
    assert np.degrees(np.linalg.norm(turn)) < 0.1
    for side, camera in (("left", LEFT), ("right", RIGHT)):
        K = np.array(found[f"K_{side}"])
        assert [K[0, 0], K[1, 1]] == pytest.approx([camera.K[0, 0], camera.K[1, 1]], rel=2e-3)
        assert K[:2, 2] == pytest.approx(camera.K[:2, 2], abs=1)
    # far from right it is neither by the deviations it claims
    assert found["error"]["mahalanobis"] < 2


def test_errors_are_measured_less_true(calibrated):
    found = calibrated.printed
    error = found["error"]
    assert error["baseline_mm"] == pytest.approx(found["baseline_mm"] - BASELINE, abs=1e-12)
    assert error["T_mm"] == pytest.approx(np.subtract(found["T_mm"], T), abs=1e-12)
    fx = error["parameters"]["left.fx"]
    assert fx["error"] == pytest.approx(found["K_left"][0][0] - LEFT.K[0, 0], abs=1e-12)


def test_corners_lie_where_they_are(calibrated):
    error = calibrated.printed["corner_error_px"]
    assert error["points"] == 8 * 2 * 30
    assert np.abs(error["bias"]).max() < 0.005
    assert max(error["sd"]) < 0.02
    assert [view["view"] for view in error["per_view"]] == calibrated.printed["views_used"]


def test_what_fits_is_below_the_papers_figures(calibrated):
    found = calibrated.printed
    assert max(found["mean_px"].values()) < 0.052
    assert found["epipolar_px"]["mean"] < 0.3807


def test_the_error_map_is_that_of_a_needle_moved_about(calibrated):
    """Project points with the truth by OpenCV; measure each by the paper's equations."""
    found = calibrated.printed
    axes = [np.linspace(a, b, 9) for a, b in ((-5, 11), (-5, 5), (92, 104))]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    zero = np.zeros(3)
    left = LEFT.pixels(places, zero, zero)
    right = RIGHT.pixels(places, *stereo_boards.to_right(zero, zero))
    K_l, D_l, K_r, D_r = (np.array(found[k]) for k in ("K_left", "D_left", "K_right", "D_right"))
    ones = np.ones(len(places))
    ends = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-14)
    rays = [
        np.column_stack([cv2.undistortPoints(px[:, None], K, D, criteria=ends)[:, 0], ones])
        for px, K, D in ((left, K_l, D_l), (right, K_r, D_r))
    ]
    measured = []
    for d_1, d_2 in zip(rays[0], rays[1] @ np.array(found["R"]).T, strict=True):
        A = np.column_stack([d_1, found["T_mm"]])  # Eq. 22; the point is the one on the left ray
        x, y = np.linalg.lstsq(A, d_2, rcond=None)[0]
        measured.append(x / -y * d_1)
    away = np.linalg.norm(np.array(measured) - places, axis=1)
    assert found["error_at_needle_mm"]["left_out"] == 0
    assert found["error_at_needle_mm"]["mean"] == pytest.approx(away.mean(), rel=1e-6)
    assert found["error_at_needle_mm"]["max"] == pytest.approx(away.max(), rel=1e-6)


def test_the_file_holds_the_rig(calibrated):
    rig, found = read_rig(calibrated.folder / "rig.yaml"), calibrated.printed
    assert rig.left.K.tolist() == found["K_left"]
    assert rig.right.size == SIZE
    assert rig.T_lr.t == pytest.approx(found["T_mm"], abs=1e-10)
    assert pytest.approx(np.array(found["R"]), abs=1e-12) == rig.T_lr.R


def test_every_plot_is_a_picture(calibrated):
    plots = sorted(path.name for path in (calibrated.folder / "plots").iterdir())
    pictures = ["coverage.png", "epipolar.png", "error_map.png", "reprojection.png"]
    assert plots == sorted([*pictures, "calibration.json", "points.json"])
    for name in pictures:
        image = cv2.imread(str(calibrated.folder / "plots" / name))
        assert image.shape[1] > 1000
        assert image.std() > 10


def test_patterns_formats_and_a_missing_board_make_no_difference(some, ask, tmp_path):
    """Five views as the table, one of them without a board; a rig in JSON."""
    folder = some(1, 2, 3, 4, 5)
    blank = np.full((SIZE[1], SIZE[0]), 120, np.uint8)
    assert cv2.imwrite(str(folder / "right_05.png"), blank)
    (folder / "left_06.png").write_bytes((folder / "left_01.png").read_bytes())
    out = tmp_path / "rig.json"
    answer = ask(f"{folder}/left*", f"{folder}/right*", "--target", TARGET, "-o", out)
    assert (answer.code, answer.err) == (0, "")
    assert "4 views used, 2 left out" in answer.out
    assert "left out: view 05: right_05.png: the image is uniform" in answer.out
    assert "left out: view left_06: left_06.png has no right image" in answer.out
    assert "│ 04 " in answer.out
    assert "│ 05 " not in answer.out
    assert np.linalg.norm(read_rig(out).T_lr.t) == pytest.approx(BASELINE, abs=0.1)


def test_a_wrong_square_makes_a_wrong_rig_and_says_so(calibrated, some, ask):
    """Nothing in the images tells the scale: only the truth does."""
    folder = some(1, 2, 3, 4)
    truth = calibrated.boards / "truth.json"
    answer = ask(folder, "--target", "chessboard:6x5:6.06", "--truth", truth)
    assert "warning: the boards show chessboard:6x5:6, not chessboard:6x5:6.06" in answer.out
    baseline = next(line for line in answer.out.splitlines() if line.startswith("baseline "))
    assert float(baseline.split("error ")[1].split()[0]) == pytest.approx(0.01 * BASELINE, abs=0.1)


def test_overexposed_images_are_warned_of(calibrated, some, ask):
    assert calibrated.printed["warnings"] == []
    folder = some(1, 2, 3, 4)
    file = folder / "right_03.png"
    bright = cv2.convertScaleAbs(cv2.imread(str(file)), alpha=1.6)
    assert cv2.imwrite(str(file), bright)
    answer = ask(folder, "--target", TARGET)
    assert "warning: 1 images are overexposed, the first is right_03.png" in answer.out
