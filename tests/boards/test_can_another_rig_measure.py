"""`rig.measured`: one rig renders, another one measures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from boards.board_scenes import changed
from cli.command_line import in_a_process, one_line

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.light_inputs import first_difference, light_digest
from simtip.measuring_rig import measuring_rig
from simtip.rig_file import write_rig
from simtip.scene_file import dump_scene, load_scene
from simtip.spec import SceneSpec


def naming(spec: SceneSpec, path: Path | str) -> SceneSpec:
    rig = spec.rig.model_copy(update={"measured": str(path)})
    return spec.model_copy(update={"rig": rig})


def whole(spec: SceneSpec) -> SceneSpec:
    rig = spec.model_dump(mode="json")["rig"]
    for side in ("left", "right"):
        rig[side]["roi"] = None
    return changed(spec, rig=rig)


def assert_same(a: StereoRig, b: StereoRig) -> None:
    for one, other in ((a.left, b.left), (a.right, b.right)):
        assert one.size == other.size
        np.testing.assert_allclose(one.K, other.K, rtol=1e-12)
        np.testing.assert_allclose(one.distortion, other.distortion, rtol=1e-12)
    np.testing.assert_allclose(a.T_lr.R, b.T_lr.R, atol=1e-12)
    np.testing.assert_allclose(a.T_lr.t, b.T_lr.t, atol=1e-10)


@pytest.mark.parametrize("name", ["rig.yaml", "rig.xml", "rig.json"])
@pytest.mark.parametrize("of", ["crop", "whole sensors"])
def test_the_true_rig_written_to_a_file_is_the_true_rig(small_scene, tmp_path, name, of):
    true = small_scene.rig.rig()
    written = true if of == "crop" else whole(small_scene).rig.rig()
    write_rig(tmp_path / name, written)
    assert_same(measuring_rig(naming(small_scene, tmp_path / name)), true)
    assert_same(measuring_rig(small_scene), true)


def test_a_calibrations_rig_is_what_measures(small_scene, tmp_path):
    rig = whole(small_scene).rig.rig()
    K = rig.left.K + np.array([[3.0, 0, 1], [0, 2, -1], [0, 0, 0]])
    off = replace(
        rig,
        left=replace(rig.left, K=K, distortion=(0.01, 0.0, 0.0, 0.0)),
        T_lr=Pose(rig.T_lr.R, rig.T_lr.t + np.array([0.1, 0, 0])),
    )
    write_rig(tmp_path / "rig.yaml", off)
    found = measuring_rig(naming(small_scene, tmp_path / "rig.yaml"))
    x, y, width, height = small_scene.rig.left.roi
    assert_same(found, replace(
        off,
        left=off.left.cropped(x, y, width, height),
        right=off.right.cropped(*small_scene.rig.right.roi),
    ))  # fmt: skip


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_rig_of_other_images_is_refused(small_scene, scene, tmp_path, side):
    for spec in (small_scene, scene):
        rig = spec.rig.rig()
        camera = getattr(rig, side)
        wrong = replace(camera, width=camera.width + 1)
        file = tmp_path / f"{side}{camera.width}.yaml"
        write_rig(file, replace(rig, **{side: wrong}))
        with pytest.raises(InputError, match=f"is for {side} images of {camera.width + 1}x") as e:
            measuring_rig(naming(spec, file))
        assert e.value.file == str(file)
        assert "\n" not in str(e.value)


@pytest.mark.parametrize("content", [None, "no rig", "%YAML:1.0\n---\nM1: 5\n"])
def test_a_file_that_is_no_rig_is_named(small_scene, tmp_path, content):
    if content is not None:
        (tmp_path / "rig.yaml").write_text(content)
    with pytest.raises(InputError, match=r"rig\.yaml"):
        measuring_rig(naming(small_scene, tmp_path / "rig.yaml"))


def test_its_place_counts_from_the_scene_file(small_scene, tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    write_rig(tmp_path / "deep" / "rig.yaml", small_scene.rig.rig())
    (tmp_path / "deep" / "scene.yaml").write_text(dump_scene(naming(small_scene, "rig.yaml")))
    for cwd, path in ((tmp_path, "deep/scene.yaml"), (tmp_path / "deep", "scene.yaml")):
        monkeypatch.chdir(cwd)
        assert_same(measuring_rig(load_scene(path)), small_scene.rig.rig())
    elsewhere = naming(small_scene, tmp_path / "deep" / "rig.yaml")
    (tmp_path / "scene.yaml").write_text(dump_scene(elsewhere))
    assert_same(measuring_rig(load_scene(tmp_path / "scene.yaml")), small_scene.rig.rig())


def test_the_light_does_not_depend_on_it(small_scene):
    other = naming(small_scene, "any.yaml")
    assert light_digest(other) == light_digest(small_scene)
    assert first_difference(other, small_scene) is None


NUMBERS = ("tip_measured_mm", "error_mm", "status", "tip_true_mm", "tip_detected_px",
           "epipolar_distance_px", "ray_gap_mm", "error_px")  # fmt: skip


def numbers(folder: Path) -> dict:
    found = json.loads((folder / "result.json").read_text())
    return {key: found[key] for key in NUMBERS}


def assert_close(one: object, other: object) -> None:
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            assert_close(one[key], other[key])
    elif isinstance(one, list):
        for a, b in zip(one, other, strict=True):
            assert_close(a, b)
    elif isinstance(one, float):
        assert one == pytest.approx(other, abs=1e-9)
    else:
        assert one == other


@pytest.mark.slow
def test_a_result_folder_stands_on_its_own(small_scene, tmp_path):
    spec = changed(small_scene, render={"samples": 32}, detect={"min_area_px": 100})
    rig = whole(spec).rig.rig()
    off = replace(rig, T_lr=Pose(rig.T_lr.R, rig.T_lr.t + np.array([0.5, 0, 0])))
    (tmp_path / "a").mkdir()
    write_rig(tmp_path / "a" / "off.yaml", off)
    write_rig(tmp_path / "a" / "true.yaml", rig)
    scenes = {"plain": spec, "true": naming(spec, "true.yaml"), "off": naming(spec, "off.yaml")}
    for name, chosen in scenes.items():
        (tmp_path / "a" / f"{name}.yaml.scene").write_text(dump_scene(chosen))
        done = in_a_process("run", f"a/{name}.yaml.scene", "-o", f"out/{name}", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    plain, true, off_found = (numbers(tmp_path / "out" / name) for name in scenes)
    assert plain["status"] == "ok"
    assert_close(true, plain)
    # 0.5 mm of 72 in the baseline: 0.7 % of the distance.
    z = off_found["tip_measured_mm"][2] / plain["tip_measured_mm"][2] - 1
    assert 0.003 < z < 0.012
    assert off_found["tip_true_mm"] == plain["tip_true_mm"]
    # Moved away from the file that it was made with.
    (tmp_path / "a" / "off.yaml").unlink()
    (tmp_path / "out" / "off").rename(tmp_path / "moved")
    done = in_a_process("run", "moved/scene.yaml", "-o", "again", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert_close(numbers(tmp_path / "again"), off_found)


@pytest.mark.parametrize("command", ["run", "render"])
def test_a_missing_rig_is_refused_before_rendering(
    ask, small_scene, tmp_path, command, monkeypatch
):
    def never(*_, **__):
        raise AssertionError("rendered")

    monkeypatch.setattr("simtip.simulation.render_pair", never)
    (tmp_path / "scene.yaml").write_text(dump_scene(naming(small_scene, "gone.yaml")))
    answer = ask(command, str(tmp_path / "scene.yaml"), "-o", str(tmp_path / "out"))
    assert answer.code == 2
    assert "gone.yaml" in one_line(answer.err)
