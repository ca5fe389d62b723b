"""BOP knows no distortion: refused, or resampled, and then all agrees with a pinhole."""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from cli.command_line import one_line
from export.exported import exported

from simtip.camera import Camera
from simtip.export.pinhole import undistorted
from simtip.render import choose, trace_surfaces
from simtip.scene_file import load_scene

CAMERA = Camera(
    np.array([[400.0, 0, 151.3], [0, 410.0, 98.7], [0, 0, 1]]), 320, 240, (0.3, -0.1, 0.002, -0.001)
)


def test_without_being_asked_nothing_is_resampled(bent_lens, ask, tmp_path):
    answer = ask("export", str(bent_lens), "--format", "bop", "-o", str(tmp_path / "out"))
    assert answer.code == 2
    line = one_line(answer.err)
    assert "--undistort" in line
    assert str(bent_lens) in line
    assert not list(tmp_path.iterdir())


def test_a_plane_of_gray_values_is_resampled_exactly():
    """Of values that are linear in place, linear interpolation is exact to rounding."""
    v, u = np.mgrid[:240, :320]
    slopes = np.array([[13.0, 5.0], [-11.0, 17.0], [3.0, -19.0]])
    image = np.stack([20000 + a * u + b * v for a, b in slopes], axis=-1).astype(np.uint16)
    made, known = undistorted(image, CAMERA)
    rays = np.stack([(u - 151.3) / 400, (v - 98.7) / 410, np.ones_like(u, float)], axis=-1)
    places, _ = cv2.projectPoints(
        rays.reshape(-1, 3), np.zeros(3), np.zeros(3), CAMERA.K, np.array(CAMERA.distortion)
    )
    x, y = places.reshape(240, 320, 2).transpose(2, 0, 1)
    inside = (x >= 0) & (x <= 319) & (y >= 0) & (y <= 239)
    assert np.array_equal(known, inside)
    assert 0.5 < known.mean() < 1
    wanted = np.stack([20000 + a * x + b * y for a, b in slopes], axis=-1)
    assert np.abs(made - wanted)[known].max() <= 0.5 + 1e-9
    assert not made[~known].any()


def test_a_picture_is_opencvs_undistorted_one():
    picture = np.random.default_rng(3).integers(0, 255, (240, 320, 3)).astype(np.uint8)
    picture = cv2.GaussianBlur(picture, (0, 0), 3)
    made, known = undistorted(picture, CAMERA)
    theirs = cv2.undistort(picture, CAMERA.K, np.array(CAMERA.distortion))
    inner = cv2.erode(known.astype(np.uint8), np.ones((5, 5))) > 0
    # Theirs rounds places to 1/32 px.
    assert np.abs(made.astype(int) - theirs)[inner].max() <= 2


def test_a_pinholes_image_stays_as_it_is():
    picture = np.random.default_rng(3).integers(0, 255, (240, 320, 3)).astype(np.uint8)
    made, known = undistorted(picture, replace(CAMERA, distortion=()))
    assert made is picture
    assert known.all()


@pytest.fixture(scope="module")
def out(bent_lens, tmp_path_factory):
    folder = tmp_path_factory.mktemp("undistorted") / "out"
    return exported(folder, "bop", bent_lens, more=("--undistort",))


def test_the_undistorted_image_has_the_needle_where_the_mask_is(out):
    scene = out / "test" / "000000"
    for name in ("000000", "000001"):
        image = cv2.imread(str(scene / "rgb" / f"{name}.png"), cv2.IMREAD_GRAYSCALE)
        mask = cv2.imread(str(scene / "mask_visib" / f"{name}_000000.png"), 0)
        known = cv2.imread(str(scene / "depth" / f"{name}.png"), -1) > 0
        inner = cv2.erode(mask, np.ones((3, 3)), borderValue=255) > 0
        outer = cv2.dilate(mask, np.ones((5, 5))) > 0
        assert np.median(image[inner]) < 0.6 * np.median(image[known & ~outer])
        # The needle's dark edge falls within a pixel of the mask's.
        row = 150
        dark = np.flatnonzero(image[row] < 0.75 * np.median(image[known & ~outer]))
        marked = np.flatnonzero(mask[row])
        dark = dark[(dark > marked[0] - 5) & (dark < marked[-1] + 5)]
        assert abs(dark[0] - marked[0]) <= 1
        assert abs(dark[-1] - marked[-1]) <= 1


def test_masks_and_depth_are_the_pinholes_own_not_resampled(out, bent_lens):
    spec = load_scene(bent_lens / "scene.yaml")
    data = spec.model_dump(mode="json")
    for side in ("left", "right"):
        data["rig"][side]["lens"]["distortion"] = []
    plain = type(spec).model_validate(data)
    scene = out / "test" / "000000"
    for k, seen in enumerate(trace_surfaces(plain, backend=choose("llvm"))):
        mask = cv2.imread(str(scene / "mask" / f"{k:06d}_000000.png"), 0) > 0
        depth = cv2.imread(str(scene / "depth" / f"{k:06d}.png"), -1) * 0.01
        assert np.array_equal(mask, seen.silhouette)
        assert np.abs(depth - seen.depth_mm)[depth > 0].max() < 0.0051


def test_where_the_lens_did_not_look_there_is_neither_image_nor_depth(out):
    scene = out / "test" / "000000"
    blank = 0
    for name in ("000000", "000001"):
        image = cv2.imread(str(scene / "rgb" / f"{name}.png"))
        depth = cv2.imread(str(scene / "depth" / f"{name}.png"), -1)
        visible = cv2.imread(str(scene / "mask_visib" / f"{name}_000000.png"), 0)
        assert np.array_equal(depth == 0, (image == 0).all(axis=-1))
        assert not visible[depth == 0].any()
        blank += int((depth == 0).sum())
    assert blank > 0


def test_the_tip_lands_on_the_dark_end_of_the_needle(out, bent_lens):
    """K and pose put the tip where the undistorted true pixel is."""
    truth = json.loads((bent_lens / "truth.json").read_text())
    scene = out / "test" / "000000"
    cameras = json.loads((scene / "scene_camera.json").read_text())
    poses = json.loads((scene / "scene_gt.json").read_text())
    for k, side in enumerate(("left", "right")):
        K = np.reshape(cameras[str(k)]["cam_K"], (3, 3))
        assert K.tolist() == truth[side]["K_px"]
        pose = poses[str(k)][0]
        place = K @ pose["cam_t_m2c"]  # a cone's tip is the model's origin
        distorted = np.array(truth[side]["tip_px"]).reshape(1, 1, 2)
        coefficients = np.array(truth[side]["distortion"])
        ideal = cv2.undistortPoints(distorted, K, coefficients, P=K).ravel()
        assert np.allclose(place[:2] / place[2], ideal, atol=1e-3)
        assert np.linalg.norm(ideal - distorted.ravel()) > 0.1
