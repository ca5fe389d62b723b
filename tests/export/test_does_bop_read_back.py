"""BOP's layout field by field, and every pixel of mask and depth by rays at the exported model."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from export.exported import exported
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from simtip.export.bop_model import diameter, symmetries
from simtip.export.bop_view import depth_scale
from simtip.needle import Bevel, Blunt, Cone, Diamond, Franseen, Lancet, Needle, Trocar
from simtip.scene_file import load_scene


def read(file: Path):
    return json.loads(file.read_text())


def png(file: Path) -> np.ndarray:
    image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    assert image is not None, file
    return image


@pytest.fixture(scope="module")
def out(plain, bevel, hidden, tmp_path_factory) -> Path:
    return exported(tmp_path_factory.mktemp("bop") / "out", "bop", plain, bevel, hidden)


@cache
def scene_of(out: Path, number: int) -> dict:
    folder = out / "test" / f"{number:06d}"
    names = ("scene_camera", "scene_gt", "scene_gt_info")
    return {"folder": folder, **{name: read(folder / f"{name}.json") for name in names}}


@cache
def cast(out: Path, number: int, image: int) -> tuple[np.ndarray, np.ndarray]:
    """Cast rays at the model through centres of pixels.

    Gives (H, W) which pixels were tried, since rays are costly: all near the mask's border, and
    some elsewhere; and camera z, mm, inf where a ray misses.
    """
    scene = scene_of(out, number)
    camera, (pose,) = scene["scene_camera"][str(image)], scene["scene_gt"][str(image)]
    K, R = np.reshape(camera["cam_K"], (3, 3)), np.reshape(pose["cam_R_m2c"], (3, 3))
    t = np.array(pose["cam_t_m2c"])
    mesh = trimesh.load(out / "models" / f"obj_{pose['obj_id']:06d}.ply", process=False)
    mask = png(scene["folder"] / "mask" / f"{image:06d}_000000.png")
    v, u = np.mgrid[: mask.shape[0], : mask.shape[1]]
    # (0, 0) is the centre of the top-left pixel.
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones(mask.shape)], -1)
    border = cv2.dilate(mask, np.ones((5, 5))) != cv2.erode(mask, np.ones((5, 5)))
    border[: mask.shape[0] // 2] &= v[: mask.shape[0] // 2] % 4 == 0
    tried = border | ((u % 7 == 0) & (v % 7 == 0))
    directions = rays[tried] @ R
    places, which, _ = mesh.ray.intersects_location(
        np.tile(-R.T @ t, (len(directions), 1)), directions, multiple_hits=False
    )
    found = np.full(len(directions), np.inf)
    found[which] = (places @ R.T + t)[:, 2]
    z = np.full(mask.shape, np.inf)
    z[tried] = found
    return tried, z


VIEWS = [(number, image) for number in range(3) for image in (0, 1)]
CAST = [
    view if view in {(1, 0), (2, 1)} else pytest.param(*view, marks=pytest.mark.slow)
    for view in VIEWS
]
"""A bevel, and a needle behind a cable: rays are costly."""


@pytest.mark.slow
@pytest.mark.parametrize(("number", "image"), VIEWS)
def test_the_model_cast_at_by_pose_and_camera_is_the_mask_pixel_by_pixel(out, number, image):
    folder = scene_of(out, number)["folder"]
    mask = png(folder / "mask" / f"{image:06d}_000000.png")
    assert mask.dtype == np.uint8
    assert set(np.unique(mask)) == {0, 255}
    tried, z = cast(out, number, image)
    # Single precision in the renderer: of rays that graze, one in some thousand may go either way.
    assert (np.isfinite(z) != (mask > 0))[tried].sum() <= 2
    assert np.isfinite(z).sum() > 600
    assert (mask == 0)[tried].sum() > 600


@pytest.mark.parametrize(("number", "image"), CAST)
def test_depth_is_the_models_where_it_is_seen_and_nearer_where_it_is_hidden(out, number, image):
    scene = scene_of(out, number)
    folder, scale = scene["folder"], scene["scene_camera"][str(image)]["depth_scale"]
    counts = png(folder / "depth" / f"{image:06d}.png")
    assert counts.dtype == np.uint16
    depth, (_, model) = counts * scale, cast(out, number, image)
    mask = png(folder / "mask" / f"{image:06d}_000000.png") > 0
    visible = png(folder / "mask_visib" / f"{image:06d}_000000.png") > 0
    assert not (visible & ~mask).any()
    both = visible & np.isfinite(model)
    # Half a count, and the needle's front at grazing rays.
    assert np.abs(depth - model)[both].max() < scale / 2 + 2e-3
    covered = mask & ~visible & np.isfinite(model)
    assert (depth[covered] < model[covered] - 0.1).all()
    assert (depth[~mask] > 0).all()


@pytest.mark.parametrize("image", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_something_before_the_needle_is_in_the_mask_and_not_in_the_visible_one(out, image):
    """The toolkit's own rule: visible where the scene is not nearer than the model."""
    scene = scene_of(out, 2)
    folder, scale = scene["folder"], scene["scene_camera"][str(image)]["depth_scale"]
    depth = png(folder / "depth" / f"{image:06d}.png") * scale
    tried, model = cast(out, 2, image)
    visible, mask = (
        png(folder / kind / f"{image:06d}_000000.png") > 0 for kind in ("mask_visib", "mask")
    )
    by_depth = np.isfinite(model) & (model - depth <= 0.05)
    assert (by_depth != visible)[tried].sum() <= 2
    assert 300 < mask.sum() - visible.sum() < 2500


@pytest.mark.parametrize(("number", "image"), VIEWS)
def test_counts_and_boxes_are_those_of_the_masks(out, number, image):
    scene = scene_of(out, number)
    (info,) = scene["scene_gt_info"][str(image)]
    mask, visible = (
        png(scene["folder"] / kind / f"{image:06d}_000000.png") > 0
        for kind in ("mask", "mask_visib")
    )
    assert set(info) == {
        *("bbox_obj", "bbox_visib", "px_count_all", "px_count_valid", "px_count_visib"),
        "visib_fract",
    }
    ys, xs = visible.nonzero()
    assert info["bbox_visib"] == [xs.min(), ys.min(), np.ptp(xs), np.ptp(ys)]
    assert info["px_count_visib"] == visible.sum()
    assert info["px_count_valid"] == mask.sum()
    assert info["visib_fract"] == visible.sum() / info["px_count_all"]
    # The shaft goes on above the image, up to the canvas's end one height farther up.
    x, y, _, height = info["bbox_obj"]
    assert y == -mask.shape[0]
    assert y + height == mask.nonzero()[0].max()
    assert mask.sum() * 1.5 < info["px_count_all"] < mask.sum() * 3
    assert x <= mask.nonzero()[1].min()


def test_the_silhouette_beyond_the_image_is_the_projected_needles(out):
    """A cone on a cylinder: its widths by rays tangent to the cylinder, row by row."""
    scene = scene_of(out, 0)
    pose = scene["scene_gt"]["0"][0]
    K = np.reshape(scene["scene_camera"]["0"]["cam_K"], (3, 3))
    x, _, z = pose["cam_t_m2c"]  # upright: the axis is the camera's -y
    distance, radius = np.hypot(x, z), 0.835
    half = np.arcsin(radius / distance)
    edges = K[0, 0] * np.tan(np.arctan2(x, z) + np.array([-half, half])) + K[0, 2]
    wide = np.floor(edges[1]) - np.ceil(edges[0]) + 1
    mask = png(scene["folder"] / "mask" / "000000_000000.png") > 0
    outside = scene["scene_gt_info"]["0"][0]["px_count_all"] - mask.sum()
    assert outside == wide * mask.shape[0]


def test_the_two_cameras_stand_as_in_the_rig_that_opencv_reads(out, plain):
    file = cv2.FileStorage(str(plain / "rig_true.yaml"), cv2.FILE_STORAGE_READ)
    cameras = scene_of(out, 0)["scene_camera"]
    assert set(cameras) == {"0", "1"}
    for image, name in (("0", "M1"), ("1", "M2")):
        assert np.array_equal(np.reshape(cameras[image]["cam_K"], (3, 3)), file.getNode(name).mat())
        assert set(cameras[image]) == {"cam_K", "depth_scale", "cam_R_w2c", "cam_t_w2c"}
    R, t = (
        [np.reshape(cameras[k][f"cam_{name}_w2c"], shape) for k in ("0", "1")]
        for name, shape in (("R", (3, 3)), ("t", (3,)))
    )
    assert np.array_equal(R[0], np.eye(3))
    assert not t[0].any()
    assert np.allclose(R[1], file.getNode("R").mat(), atol=1e-15)
    assert np.allclose(t[1], file.getNode("T").mat().ravel(), atol=1e-12)


def test_the_tip_of_the_model_lands_on_the_true_tip(out, plain, bevel):
    for number, source in enumerate((plain, bevel)):
        scene, truth = scene_of(out, number), read(source / "truth.json")
        for image, side in enumerate(("left", "right")):
            (pose,) = scene["scene_gt"][str(image)]
            assert set(pose) == {"obj_id", "cam_R_m2c", "cam_t_m2c"}
            tip = np.array(read(out / "models" / "tips.json")[str(pose["obj_id"])]["tip_mm"])
            K = np.reshape(scene["scene_camera"][str(image)]["cam_K"], (3, 3))
            R = np.reshape(pose["cam_R_m2c"], (3, 3))
            found, _ = cv2.projectPoints(
                tip.reshape(1, 3), cv2.Rodrigues(R)[0], np.array(pose["cam_t_m2c"]), K, None
            )
            assert np.allclose(found.ravel(), truth[side]["tip_px"], atol=1e-6)


def test_images_are_the_rendered_ones_in_8_bit(out, plain, bevel):
    for image, side in enumerate(("left", "right")):
        name = f"{image:06d}.png"
        same = png(out / "test" / "000000" / "rgb" / name)
        assert np.array_equal(same, png(plain / f"{side}.png"))
        deep, shallow = png(bevel / f"{side}.png"), png(out / "test" / "000001" / "rgb" / name)
        assert deep.dtype == np.uint16
        assert shallow.dtype == np.uint8
        assert np.abs(shallow - deep * (255 / 4095)).max() <= 0.5


def test_the_files_are_where_bop_looks_for_them(out):
    found = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}
    own = {"dataset_info.md", "sources.csv", "models/tips.json"}
    models = {"models/models_info.json", "models/obj_000001.ply", "models/obj_000002.ply"}
    per_scene = {
        *("scene_camera.json", "scene_gt.json", "scene_gt_info.json"),
        *(f"{kind}/00000{k}.png" for kind in ("rgb", "depth") for k in (0, 1)),
        *(f"{kind}/00000{k}_000000.png" for kind in ("mask", "mask_visib") for k in (0, 1)),
    }
    scenes = {f"test/00000{number}/{name}" for number in range(3) for name in per_scene}
    assert found == {*own, *models, *scenes, "camera.json", "test_targets_bop19.json"}


def test_camera_and_targets_have_bops_fields(out):
    camera, first = read(out / "camera.json"), scene_of(out, 0)["scene_camera"]["0"]
    assert (camera["width"], camera["height"]) == (140, 360)
    K = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]])
    assert K.ravel().tolist() == first["cam_K"]
    assert camera["depth_scale"] == first["depth_scale"] == 0.01
    targets = read(out / "test_targets_bop19.json")
    assert targets == [
        {"im_id": image, "inst_count": 1, "obj_id": 2 if number == 1 else 1, "scene_id": number}
        for number, image in VIEWS
    ]


def test_models_info_is_the_models_own(out):
    info = read(out / "models" / "models_info.json")
    for number in ("1", "2"):
        mesh = trimesh.load(out / "models" / f"obj_{int(number):06d}.ply", process=False)
        assert mesh.is_watertight
        assert mesh.volume > 300  # outward
        low, high = mesh.bounds
        told = info[number]
        assert np.allclose([told[f"min_{axis}"] for axis in "xyz"], low, atol=1e-5)
        assert np.allclose([told[f"size_{axis}"] for axis in "xyz"], high - low, atol=1e-5)
        assert told["diameter"] == pytest.approx(pdist(mesh.vertices).max(), abs=1e-5)
    assert info["1"]["symmetries_continuous"] == [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]
    assert not any(name.startswith("symmetries") for name in info["2"])
    header = (out / "models" / "obj_000001.ply").read_text().partition("end_header")[0]
    assert "format ascii 1.0" in header
    assert "property float nz" in header


TIPS = {
    "trocar": (Trocar(20), 3),
    "diamond": (Diamond(20), 4),
    "franseen": (Franseen(20), 3),
    "cone": (Cone(5), None),
    "blunt": (Blunt(), None),
    "bevel": (Bevel(20), 1),
    "lancet": (Lancet(12, 18, 35, 0.5), 1),
}


@pytest.mark.parametrize("name", TIPS)
def test_stated_turns_leave_the_needle_as_it_is_and_no_others_do(name):
    tip, folds = TIPS[name]
    needle = Needle(1.67, 20, tip)
    said = symmetries(needle)
    vertices, _ = needle.surface(48, sagitta_mm=0.01)
    surface = cKDTree(needle.mesh(960).sample(400_000, seed=1))

    def off(angle: float) -> float:
        c, s = np.cos(angle), np.sin(angle)
        turned = vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        return float(surface.query(turned)[0].max())

    if folds is None:
        assert list(said) == ["symmetries_continuous"]
        assert max(off(angle) for angle in (0.3, 1.1, 2.0)) < 0.05
        return
    turns = said.get("symmetries_discrete", [])
    assert len(turns) == folds - 1
    for k, matrix in enumerate(turns, start=1):
        R = np.reshape(matrix, (4, 4))
        assert np.array_equal(R[3], [0, 0, 0, 1])
        angle = np.arctan2(R[1, 0], R[0, 0])
        assert angle % (2 * np.pi) == pytest.approx(2 * np.pi * k / folds)
        assert off(angle) < 0.05
    for angle in (np.pi / folds, np.pi / 2 / folds):
        assert off(angle) > 0.1


def test_a_bent_needle_has_no_symmetry():
    assert symmetries(Needle(1.67, 60, Cone(5), bend_radius_mm=200)) == {}


def test_the_diameter_is_the_longest_distance_of_all():
    points = np.random.default_rng(1).normal(size=(3000, 3)) * [1, 2, 5]
    assert diameter(points) == pytest.approx(pdist(points).max(), rel=1e-15)


@pytest.mark.parametrize(
    ("largest", "scale"),
    [(0, 0.01), (655.35, 0.01), (655.4, 0.02), (1400, 0.05), (4000, 0.1), (6554, 0.2), (70000, 2)],
)
def test_a_count_of_depth_is_as_fine_as_16_bit_allow(largest, scale):
    assert depth_scale(largest) == scale


def test_an_even_background_lies_where_the_scene_has_it(out, plain):
    """Depth outside the needle by the plane's equation, to half a count."""
    scene, spec = scene_of(out, 0), load_scene(plain / "scene.yaml")
    for image in (0, 1):
        camera = scene["scene_camera"][str(image)]
        K, R = np.reshape(camera["cam_K"], (3, 3)), np.reshape(camera["cam_R_w2c"], (3, 3))
        t = np.array(camera["cam_t_w2c"])
        depth = png(scene["folder"] / "depth" / f"{image:06d}.png") * camera["depth_scale"]
        mask = png(scene["folder"] / "mask" / f"{image:06d}_000000.png") > 0
        v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
        rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T
        normal, centre = R @ spec.background.normal, R @ spec.background.centre_mm + t
        plane = (centre @ normal) / (rays @ normal)
        assert np.abs(depth - plane)[~mask].max() < 0.005 + 1e-4
