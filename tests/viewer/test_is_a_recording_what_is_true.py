"""Entities and numbers of a recording, against the folder that it is of."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from asked import call
from viewer.recorded import Recorded

IMAGE = "/world/cameras/{}/image"


def record(file: Path, *folders: Path, more: tuple[str, ...] = ()) -> Recorded:
    answer = call("view", *map(str, folders), "--save", str(file), *more)
    assert answer.code == 0, answer.err
    assert str(file) in answer.out
    return Recorded(file)


@pytest.fixture(scope="module")
def run(plain, saved) -> Recorded:
    return record(saved / "run.rrd", plain)


@pytest.fixture(scope="module")
def truth(plain) -> dict:
    return json.loads((plain / "truth.json").read_text())


@pytest.fixture(scope="module")
def result(plain) -> dict:
    return json.loads((plain / "result.json").read_text())


def test_every_part_of_the_scene_is_there(run):
    wanted = {
        *("/world", "/world/needle", "/world/axis", "/world/tip/true", "/world/tip/measured"),
        *("/world/rays", "/world/gap", "/world/background", "/world/lamps", "/about"),
        "/error/norm_mm",
    }
    for side in ("left", "right"):
        image = IMAGE.format(side)
        wanted |= {f"/world/cameras/{side}", image, f"{image}/rgb"}
        wanted |= {f"{image}/tip_true", f"{image}/tip_detected"}
    assert run.entities() - {"/__properties"} == wanted
    assert run.blueprints == 1


def test_cameras_are_the_rigs(run, truth):
    for side in ("left", "right"):
        K = np.reshape(run.at(IMAGE.format(side), "image_from_camera")[0], (3, 3)).T
        # Rerun counts pixels from the corner of the first one.
        expected = np.add(truth[side]["K_px"], [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
        assert np.allclose(K, expected, rtol=1e-6)
        size = [truth[side]["width_px"], truth[side]["height_px"]]
        assert run.at(IMAGE.format(side), "resolution")[0] == size
    pose = truth["T_lr"]
    R = np.reshape(run.at("/world/cameras/right", "mat3x3")[0], (3, 3)).T
    assert np.allclose(R, pose["R"], atol=1e-6)
    assert np.allclose(run.at("/world/cameras/right", "translation")[0], pose["t_mm"], rtol=1e-6)
    assert run.at("/world/cameras/left", "translation")[0] == [0, 0, 0]


def test_images_are_the_folders_own(run, plain):
    for side in ("left", "right"):
        entity = f"{IMAGE.format(side)}/rgb"
        image = cv2.imread(str(plain / f"{side}.png"))[..., ::-1]
        held = np.array(run.at(entity, "buffer")[0], np.uint8)
        assert np.array_equal(held.reshape(image.shape), image)


def test_tips_are_the_true_and_the_measured_ones(run, truth, result):
    assert np.allclose(run.at("/world/tip/true", "positions"), [truth["tip_mm"]], atol=1e-4)
    found = run.at("/world/tip/measured", "positions")
    assert np.allclose(found, [result["tip_measured_mm"]], atol=1e-4)
    for side in ("left", "right"):
        true = np.array(run.at(f"{IMAGE.format(side)}/tip_true", "positions")) - 0.5
        assert np.allclose(true, [truth[side]["tip_px"]], atol=1e-4)
        seen = np.array(run.at(f"{IMAGE.format(side)}/tip_detected", "positions")) - 0.5
        assert np.allclose(seen, [result["tip_detected_px"][side]], atol=1e-4)
    error = result["error_mm"]["norm"]
    assert run.at("/error/norm_mm", "scalars")[0] == pytest.approx(error, rel=1e-12)


def test_rays_begin_at_the_cameras_pass_the_detected_pixels_and_miss_each_other(run, plain, result):
    rays, gap = run.at("/world/rays", "strips"), np.array(run.at("/world/gap", "strips")[0])
    file = cv2.FileStorage(str(plain / "rig_true.yaml"), cv2.FILE_STORAGE_READ)
    R, T = file.getNode("R").mat(), file.getNode("T").mat()
    centres = np.zeros(3), (-R.T @ T).ravel()
    turns = np.zeros(3), cv2.Rodrigues(R)[0]
    shifts = np.zeros(3), T
    for k, side in enumerate(("left", "right")):
        start, end = np.array(rays[k])
        assert np.allclose(start, centres[k], atol=1e-4)
        assert np.allclose(end, gap[k], atol=1e-4)
        K = file.getNode(f"M{k + 1}").mat()
        for share in (0.5, 1.0):
            point = (start + share * (end - start)).reshape(1, 3)
            pixel, _ = cv2.projectPoints(point, turns[k], shifts[k], K, None)
            assert np.allclose(pixel.ravel(), result["tip_detected_px"][side], atol=2e-3)
    assert np.linalg.norm(gap[0] - gap[1]) == pytest.approx(result["ray_gap_mm"], abs=2e-4)


def test_the_needle_is_a_solid_with_its_tip_at_the_true_one(run, truth):
    vertices = np.array(run.at("/world/needle", "vertex_positions"))
    triangles = np.array(run.at("/world/needle", "triangle_indices"))
    assert triangles.max() == len(vertices) - 1
    assert np.linalg.norm(vertices - truth["tip_mm"], axis=1).min() < 1e-4
    axis = np.array(run.at("/world/axis", "strips")[0])
    assert np.allclose(axis[0], truth["tip_mm"], atol=1e-4)  # a cone's tip lies on the axis
    assert np.allclose(axis[-1] - axis[0], 150 * np.array(truth["axis"]), atol=1e-3)
    away = vertices - axis[0]
    along = away @ truth["axis"]
    across = np.linalg.norm(away - along[:, None] * truth["axis"], axis=1)
    assert across.max() == pytest.approx(0.835, abs=1e-4)
    assert along.max() == pytest.approx(150, abs=1e-3)


def test_surroundings_are_the_scenes(run):
    outline = np.array(run.at("/world/background", "strips")[0])
    assert np.allclose(np.ptp(outline, axis=0)[:2], [800, 800], atol=1e-2)
    assert np.allclose(outline[:, 2], 260, atol=1e-3)
    assert set(run.at("/world/lamps", "labels")) == {"front", "rear"}


def test_words_are_plain_text(run, plain):
    assert run.at("/about", "media_type") == ["text/plain"]
    (text,) = run.at("/about", "text")
    assert text.splitlines()[0] == str(plain)
    assert "status: ok" in text


def test_what_was_not_measured_is_not_shown_from_before(plain, bevel, saved):
    """A rendered folder after a measured one: its tips and rays are gone."""
    two = record(saved / "two.rrd", plain, bevel)
    assert two.trials("/about", "text") == [0, 1]
    for entity, component in (
        ("/world/tip/measured", "positions"),
        ("/world/rays", "strips"),
        ("/world/gap", "strips"),
        (f"{IMAGE.format('left')}/tip_detected", "positions"),
    ):
        assert len(two.at(entity, component, 0)) > 0
        assert len(two.at(entity, component, 1)) == 0
    held = np.array(two.at(f"{IMAGE.format('left')}/rgb", "buffer", 1)[0], np.uint8)
    deep = cv2.imread(str(bevel / "left.png"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    assert np.abs(held.reshape(deep.shape) - deep * (255 / 4095)).max() <= 0.5


def test_rays_of_a_lens_with_distortion_meet_at_what_was_measured(bent_lens, saved):
    bent = record(saved / "bent.rrd", bent_lens)
    result = json.loads((bent_lens / "result.json").read_text())
    gap = np.array(bent.at("/world/gap", "strips")[0])
    assert np.linalg.norm(gap[0] - gap[1]) == pytest.approx(result["ray_gap_mm"], abs=2e-4)
    assert np.linalg.norm(gap.mean(axis=0) - result["tip_measured_mm"]) < 0.1


def test_boards_are_shown_with_their_points(boards, saved):
    shown = record(saved / "boards.rrd", boards)
    truth = json.loads((boards / "truth.json").read_text())
    assert shown.trials("/world/points", "positions") == [0, 1, 2]
    for k, view in enumerate(truth["views"]):
        world = np.array(truth["plate"]["points_mm"]) @ np.array(view["R"]).T + view["t_mm"]
        assert np.allclose(shown.at("/world/points", "positions", k), world, atol=1e-4)
        for side in ("left", "right"):
            seen = np.array(shown.at(f"{IMAGE.format(side)}/points", "positions", k)) - 0.5
            assert np.allclose(seen, view[side]["points_px"], atol=1e-3)
    outline = np.array(shown.at("/world/plate", "strips")[0])
    assert np.allclose(outline[0], outline[-1])


@pytest.mark.slow
def test_a_sweeps_trials_are_on_the_timeline(saved, tmp_path):
    from sweep.small_sweeps import run as sweep
    from sweep.small_sweeps import sweep_file

    from simtip.sweep.table import Table

    factors = {"detect.threshold": [60, 120, 250], "lamps[0].power": [1.0, 1.2]}
    sweep(sweep_file(tmp_path, factors=factors), tmp_path / "out", "--workers", "1")
    more = ("--cache", str(tmp_path / "cache"))
    shown = record(saved / "swept.rrd", tmp_path / "out", more=more)
    table = Table.open(tmp_path / "out").frame()
    assert shown.trials("/about", "text") == list(range(6))
    # Two pairs of images, each with the trials that look at it.
    assert shown.trials(f"{IMAGE.format('left')}/rgb", "buffer") == [0, 3]
    for k, row in enumerate(table.itertuples()):
        (text,) = shown.at("/about", "text", k)
        assert f"trial: {row.trial}" in text.splitlines()
        found = shown.at("/world/tip/measured", "positions", k)
        assert len(found) == (row.status == "ok")
        if row.status == "ok":
            assert np.allclose(found, [[row.tip_x_mm, row.tip_y_mm, row.tip_z_mm]], atol=1e-4)
