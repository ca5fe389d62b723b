"""COCO's annotations as pycocotools reads them, against the truth and masks traced here."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from export.exported import exported, run_into, small
from pycocotools import mask as masks
from pycocotools.coco import COCO

from simtip.export.coco import run_lengths
from simtip.render import choose, trace_surfaces
from simtip.scene_file import load_scene

# pycocotools' own, of its arrays under NumPy 2.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")


@pytest.fixture(scope="module")
def out(plain, bevel, hidden, tmp_path_factory) -> Path:
    return exported(tmp_path_factory.mktemp("coco") / "out", "coco", plain, bevel, hidden)


@pytest.fixture(scope="module")
def coco(out) -> COCO:
    return COCO(str(out / "annotations.json"))


@pytest.fixture(scope="module")
def sources(plain, bevel, hidden) -> list[Path]:
    return [plain, bevel, hidden]


def annotations_of(coco: COCO, number: int) -> list[dict]:
    """Give the annotations of the left and right image of a pair."""
    found = []
    for side in ("left", "right"):
        name = f"{number:06d}_{side}.png"
        (image,) = (key for key, told in coco.imgs.items() if told["file_name"] == name)
        (annotation,) = coco.loadAnns(coco.getAnnIds(imgIds=[image]))
        found.append(annotation)
    return found


def points_of(annotation: dict) -> np.ndarray:
    return np.reshape(annotation["keypoints"], (-1, 3))


@pytest.mark.parametrize("number", range(3))
def test_masks_decode_to_the_traced_ones_and_areas_and_boxes_are_theirs(coco, sources, number):
    spec = load_scene(sources[number] / "scene.yaml")
    traced = trace_surfaces(spec, backend=choose("llvm"))
    for annotation, surfaces in zip(annotations_of(coco, number), traced, strict=True):
        decoded = coco.annToMask(annotation)
        assert np.array_equal(decoded, surfaces.needle)
        lengths = coco.annToRLE(annotation)
        assert annotation["area"] == masks.area(lengths) == decoded.sum()
        assert annotation["bbox"] == masks.toBbox(lengths).tolist()
        assert annotation["iscrowd"] == 0


@pytest.mark.parametrize("number", range(3))
def test_masks_are_half_the_coverage_but_for_pixels_on_the_border(coco, sources, number):
    """The folder's own masks say how much of a pixel the needle covers, from a few samples."""
    for annotation, side in zip(annotations_of(coco, number), ("left", "right"), strict=True):
        coverage = cv2.imread(str(sources[number] / f"{side}_mask.png"), cv2.IMREAD_UNCHANGED)
        mask = coco.annToMask(annotation)
        inner = cv2.erode(mask, np.ones((3, 3), np.uint8), borderValue=1)
        outer = cv2.dilate(mask, np.ones((3, 3), np.uint8))
        assert (coverage[inner > 0] == 255).mean() > 0.998
        # A sharp tip may end before the next pixel's centre.
        assert (coverage[outer == 0] > 0).sum() <= 4


@pytest.mark.parametrize("number", range(2))
def test_the_tip_is_the_true_one_to_the_last_bit(coco, sources, number):
    truth = json.loads((sources[number] / "truth.json").read_text())
    for annotation, side in zip(annotations_of(coco, number), ("left", "right"), strict=True):
        u, v, flag = points_of(annotation)[0]
        assert [u, v] == truth[side]["tip_px"]
        assert flag == (2 if truth[side]["tip_visible"] else 1)


def test_the_second_point_is_10_mm_up_the_axis(coco, plain):
    """By OpenCV from the rig's file."""
    file = cv2.FileStorage(str(plain / "rig_true.yaml"), cv2.FILE_STORAGE_READ)
    truth = json.loads((plain / "truth.json").read_text())
    point = np.array(truth["tip_mm"]) + 10 * np.array(truth["axis"])
    rotations = np.zeros((3, 1)), cv2.Rodrigues(file.getNode("R").mat())[0]
    shifts = np.zeros((3, 1)), file.getNode("T").mat()
    for k, annotation in enumerate(annotations_of(coco, 0)):
        K = file.getNode(f"M{k + 1}").mat()
        seen, _ = cv2.projectPoints(point.reshape(1, 3), rotations[k], shifts[k], K, None)
        assert np.allclose(points_of(annotation)[1, :2], seen.ravel(), atol=1e-9)
        assert points_of(annotation)[1, 2] == 2
        assert annotation["num_keypoints"] == 2


def test_what_a_cable_hides_is_labelled_and_not_visible(coco):
    left, right = (points_of(annotation) for annotation in annotations_of(coco, 2))
    assert left[:, 2].tolist() == [1, 1]
    assert right[:, 2].tolist() == [1, 2]
    mask = coco.annToMask(annotations_of(coco, 2)[0])
    u, v = np.rint(left[1, :2]).astype(int)
    assert not mask[v, u]


def test_what_is_outside_the_image_is_not_labelled(tmp_path, scene):
    data = small(scene)
    left = data.rig.left.model_copy(update={"roi": (740, 560, 140, 280)})
    spec = data.model_copy(update={"rig": data.rig.model_copy(update={"left": left})})
    folder = run_into(tmp_path / "cut", spec)
    coco = COCO(str(exported(tmp_path / "out", "coco", folder) / "annotations.json"))
    above, whole = annotations_of(coco, 0)
    assert points_of(above)[0].tolist() == [0, 0, 0]
    assert points_of(above)[1, 2] == 2
    assert (above["num_keypoints"], whole["num_keypoints"]) == (1, 2)


@pytest.mark.slow
def test_a_needle_that_nothing_is_seen_of_has_no_annotation(tmp_path, scene):
    data = small(scene)
    left = data.rig.left.model_copy(update={"roi": (0, 0, 40, 40)})
    spec = data.model_copy(update={"rig": data.rig.model_copy(update={"left": left})})
    folder = run_into(tmp_path / "away", spec)
    coco = COCO(str(exported(tmp_path / "out", "coco", folder) / "annotations.json"))
    assert len(coco.imgs) == 2
    (annotation,) = coco.anns.values()
    assert coco.imgs[annotation["image_id"]]["file_name"] == "000000_right.png"


def test_images_and_categories_are_what_the_files_hold(out, coco):
    assert len(coco.imgs) == len(coco.anns) == 6
    for told in coco.imgs.values():
        image = cv2.imread(str(out / "images" / told["file_name"]), cv2.IMREAD_UNCHANGED)
        assert image.shape == (told["height"], told["width"], 3)
        assert image.dtype == np.uint8
    (category,) = coco.cats.values()
    assert category["name"] == "needle"
    assert category["keypoints"] == ["tip", "axis_10mm"]
    assert category["skeleton"] == [[1, 2]]
    assert sorted(path.name for path in out.iterdir()) == [
        "annotations.json",
        "images",
        "sources.csv",
    ]


@pytest.mark.parametrize("seed", range(5))
def test_run_lengths_are_pycocotools_own(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((17, 23)) < (0.0, 0.1, 0.5, 0.9, 1.0)[seed]
    ours = masks.frPyObjects(run_lengths(mask), *mask.shape)
    theirs = masks.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert ours == theirs
    assert np.array_equal(masks.decode(ours), mask)


def test_points_of_boards_are_keypoints_joined_as_a_grid(boards, tmp_path):
    out = exported(tmp_path / "out", "coco", boards)
    coco = COCO(str(out / "annotations.json"))
    truth = json.loads((boards / "truth.json").read_text())
    (category,) = coco.cats.values()
    assert category["name"] == truth["target"] == "chessboard:3x3:1.5"
    assert len(category["keypoints"]) == 9
    assert len(category["skeleton"]) == 12
    for k, view in enumerate(truth["views"]):
        for annotation, side in zip(annotations_of(coco, k), ("left", "right"), strict=True):
            points = points_of(annotation)
            assert np.array_equal(points[:, :2], view[side]["points_px"])
            assert (points[:, 2] == 2).all()
            x, y, width, height = annotation["bbox"]
            # Boxes count from the first pixel's corner, keypoints from its centre.
            assert np.allclose(points[:, :2].min(axis=0) + 0.5, [x, y])
            assert np.allclose(points[:, :2].max(axis=0) + 0.5, [x + width, y + height])
            joined = np.array(category["skeleton"]) - 1
            steps = np.linalg.norm(points[joined[:, 0], :2] - points[joined[:, 1], :2], axis=1)
            assert steps.max() < 1.5 * steps.min()
