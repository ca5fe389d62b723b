"""`render`, `rig`, `schema`, `doctor` and `--version`: what is on stdout and what is written."""

from __future__ import annotations

import importlib.metadata
import json

import pytest
import yaml
from command_line import SCENE

from simtip.rig_file import read_rig
from simtip.scene_file import load_scene
from simtip.truth import scene_truth


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rendered")
    (folder / "scene.yaml").write_text(SCENE)
    return folder


@pytest.mark.slow
def test_render_gives_the_images_of_run_and_the_truth_alone(ran, rendered, ask, monkeypatch):
    monkeypatch.chdir(rendered)
    answer = ask("render", "scene.yaml", "-o", "deep/out", "--exr", "--json")
    assert (answer.code, answer.err) == (0, "")
    printed = json.loads(answer.out)
    out = rendered / "deep" / "out"
    truth = json.loads((out / "truth.json").read_text())
    assert printed["truth"] == truth == ran.saved("truth.json")
    assert (printed["scene"], printed["seed"]) == ("bench", 3)
    assert printed["out"] == "deep/out"
    assert printed["backend"] == ran.printed["backend"]
    assert set(printed["timings_s"]) == {"render", "sensor"}
    assert {p.name for p in out.iterdir()} == {
        *("left.png", "right.png", "left_mask.png", "right_mask.png", "left.exr", "right.exr"),
        *("truth.json", "scene.yaml", "rig_true.yaml", "manifest.json"),
    }
    for name in ("left.png", "right.png", "left_mask.png", "scene.yaml", "rig_true.yaml"):
        assert (out / name).read_bytes() == (ran.folder / name).read_bytes(), name


def test_rig_prints_the_file_that_run_writes(ran, bench, ask):
    answer = ask("rig", "scene.yaml")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == (ran.folder / "rig_true.yaml").read_text()
    assert ask("rig", "scene.yaml", "-o", "new.yaml").out == ""
    assert (bench / "new.yaml").read_text() == answer.out


def test_the_exported_rig_is_the_one_of_the_truth(bench, ask):
    ask("rig", "scene.yaml", "-o", "new.yaml")
    rig, truth = read_rig(bench / "new.yaml"), scene_truth(load_scene(bench / "scene.yaml")).rig
    assert rig.T_lr.t == pytest.approx(truth.T_lr.t, abs=1e-12)
    assert rig.left.K.tolist() == truth.left.K.tolist()


def test_schema_knows_every_key_of_a_scene(ask):
    answer = ask("schema")
    assert (answer.code, answer.err) == (0, "")
    schema = json.loads(answer.out)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert set(yaml.safe_load(SCENE)) < set(schema["properties"])
    assert schema["additionalProperties"] is False
    sensor = schema["$defs"]["SensorSpec"]
    assert "exposure_s" in sensor["properties"]
    assert sensor["properties"]["exposure_s"]["maximum"] == 100


def test_version_is_the_installed_one(ask):
    answer = ask("--version")
    installed = importlib.metadata.version("simtip")
    assert (answer.code, answer.out, answer.err) == (0, f"simtip {installed}\n", "")


@pytest.mark.parametrize("command", ["run", "render", "measure", "rig", "doctor", "schema"])
def test_help_is_no_error(command, ask):
    answer = ask(command, "--help")
    assert (answer.code, answer.err) == (0, "")
    assert command in answer.out


def test_a_scene_without_a_tip_is_a_result(bench, ask, monkeypatch):
    """A needle smaller than `min_area_px`: status and reason, null and exit code 0."""
    monkeypatch.setenv("SIMTIP_BACKEND", "auto")
    (bench / "scene.yaml").write_text(SCENE.replace("min_area_px: 200", "min_area_px: 4500"))
    answer = ask("run", "scene.yaml", "--json", "-o", "out")
    assert (answer.code, answer.err) == (0, "")
    result = json.loads(answer.out)
    assert result["status"] == "left_no_component_large_enough"
    assert "4500" in result["reason"]
    assert result["tip_measured_mm"] is None
    assert result["error_mm"] is None
    assert result["tip_detected_px"] == {"left": None, "right": None}
    assert result["epipolar_distance_px"] is None
    assert result["tip_true_mm"] == [-10, 20, 170]
    assert json.loads((bench / "out" / "result.json").read_text()) == result
    assert (bench / "out" / "overlay.png").stat().st_size > 0
