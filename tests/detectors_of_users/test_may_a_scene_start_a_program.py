"""Does a scene run what it names only with its user's word?"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass

import pytest
import yaml
from programs import program

from simtip.errors import InputError
from simtip.scene_file import dump_scene, load_scene
from simtip.trial import detector_of, run_trial, with_detector


@dataclass
class Trap:
    """A scene that names code, and the mark that the code leaves where it runs."""

    scene: str
    reference: str
    mark: object

    def sprung(self) -> bool:
        return self.mark.exists()


@pytest.fixture(params=["command", "module"])
def trap(request, tmp_path, monkeypatch, small_scene):
    monkeypatch.chdir(tmp_path)
    mark = tmp_path / "mark"
    leave = f"open({str(mark)!r}, 'w').close()"
    name = f"trap_{request.param}"
    body = f"{leave}\nprint(json.dumps([40, 80]))"
    reference = program(tmp_path, body, "{image} {gain}", name=f"{name}.py")
    if request.param == "module":
        (tmp_path / f"{name}.py").write_text(
            f"{leave}\ndef find(image, gain: int = 1): return (40, 80)\n"
        )
        reference = f"{name}:find"
    data = yaml.safe_load(dump_scene(small_scene))
    data["detect"] = {"name": reference, "gain": 2}
    data["render"]["samples"] = 4
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(data))
    yield Trap("scene.yaml", reference, mark)
    sys.modules.pop(name, None)


def test_opening_it_runs_nothing(trap, ask):
    for more in ((), ("--set", "gain=3"), ("--detector", "cmd:./other {image}")):
        answer = ask("run", trap.scene, "--json", "--backend", "nope", *more)
        assert answer.code == 2
        assert not trap.sprung()
    answer = ask("run", trap.scene)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("simtip: scene.yaml:")
    assert "detect.name: a scene may not start a program or import a module" in answer.err
    assert "--detector" in answer.err
    assert answer.err.count("\n") == 1
    assert not trap.sprung()


def test_reading_and_exporting_it_runs_nothing(trap, ask):
    assert load_scene(trap.scene).detect.name == trap.reference
    assert ask("rig", trap.scene).code == 0
    assert not trap.sprung()


def test_python_refuses_it_too_unless_told(trap):
    spec = load_scene(trap.scene)
    for look in (detector_of, run_trial):
        with pytest.raises(InputError, match="a scene may not"):
            look(spec)
    with pytest.raises(InputError, match="a scene may not"):
        detector_of(spec, allowed="cmd:./other {image}")
    assert not trap.sprung()
    assert detector_of(spec, allowed=trap.reference) is not None


@pytest.mark.slow
def test_the_same_reference_on_the_command_line_lets_it_run(trap, ask):
    answer = ask("run", trap.scene, "--detector", trap.reference, "--json")
    assert answer.code == 0, answer.err
    result = json.loads(answer.out)
    assert result["detector"] == trap.reference
    assert result["tip_detected_px"]["left"] == [40, 80]
    assert trap.sprung()


@pytest.mark.slow
def test_a_run_that_is_told_from_python_runs(trap):
    spec = load_scene(trap.scene)
    trial = run_trial(spec, detector=trap.reference)
    assert trial.measurement.left.ok, trial.measurement.reason
    assert trap.sprung()


def test_settings_take_the_place_of_the_scenes(small_scene):
    own = small_scene.detect.name
    spec = with_detector(small_scene, None, {"threshold": "90"})
    kept = with_detector(spec, own, {"min_area_px": "7"})
    assert kept.detect.name == own
    assert kept.detect.parameters()["threshold"] == "90"
    assert kept.detect.parameters()["min_area_px"] == "7"
    assert with_detector(spec, "other", {}).detect.parameters() == {}


def test_an_error_names_where_the_value_stands(ask, tmp_path, small_scene, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(dump_scene(small_scene).replace("lin2020", "lin2021"))
    assert ask("run", "scene.yaml").err.startswith("simtip: scene.yaml:")
    assert ask("run", "scene.yaml", "--detector", "lin2022").err.startswith("simtip: --detector: ")
    named = ask("run", "scene.yaml", "--detector", "lin2020", "--set", "threshold=x")
    assert named.err.startswith("simtip: --set threshold: ")
    assert ask("run", "scene.yaml", "--set", "name=x").err.startswith("simtip: --set name: ")
