"""Is whatever a user can get wrong in an experiment said in one line, before anything runs?"""

from __future__ import annotations

import pytest
import yaml
from asked import call
from experiment.small_experiment import scene_file


def refused(file, *options):
    told = call("mca", str(file), *map(str, options))
    assert told.code == 2
    assert told.err.count("\n") == 1
    assert told.out == ""
    return told.err


@pytest.mark.parametrize(
    ("said", "field", "problem"),
    [
        ({"stage": {"stroke_mm": [5, 1, 1]}}, "experiment.schedule.steps", "beyond the stroke"),
        (
            {"schedule": {"accuracy_runs": 9}},
            "experiment.schedule.accuracy_runs",
            "more than the 3",
        ),
        ({"schedule": {"registration": [1, 1, 2]}}, "experiment.schedule.registration", "no plane"),
        ({"stage": {"stroke": 5}}, "experiment.stage.stroke", "did you mean"),
        ({"stage": {"backlash_mm": -1}}, "experiment.stage.backlash_mm", "from 0 to 1000"),
        ({"setups": [{"name": "accuracy"}]}, "experiment.setups", "taken"),
        (
            {"setups": [{"name": "a", "set": {"needle.tip_mm": 1}}]},
            "experiment.setups[0].set",
            "needle.tip_mm",
        ),
        (
            {"setups": [{"name": "a", "set": {"lamps[0].powr": 1}}]},
            "lamps[0].powr",
            "lamps[0].power",
        ),
        (
            {"setups": [{"name": "a", "recalibrate": {"views": 2}}]},
            "experiment.setups[0].recalibrate.views",
            "from 3 to 200",
        ),
        (
            {"stage": {"second_direction": [0, 1, 0]}},
            "experiment.stage.second_direction",
            "first axis",
        ),
    ],
)
def test_a_wrong_field_is_named(tmp_path, said, field, problem):
    line = refused(scene_file(tmp_path, **said), "-o", tmp_path / "out")
    assert field in line
    assert problem in line
    assert "scene.yaml" in line


def test_a_frame_that_nobody_registers_is_refused(tmp_path):
    line = refused(scene_file(tmp_path), "--frame", "stage", "-o", tmp_path / "out")
    assert "--frame" in line
    assert "experiment.schedule.registration" in line


def test_an_experiment_may_stand_in_a_file_of_its_own(tmp_path):
    file = tmp_path / "experiment.yaml"
    file.write_text("schedule:\n  steps: 4\n  runs: 1")
    line = refused(scene_file(tmp_path), "--experiment", file)
    assert "experiment.yaml:3: schedule.runs" in line
    file.write_text(yaml.safe_dump({"stage": {"stroke_mm": [1, 1, 1]}}))
    assert "experiment.yaml:1: schedule.steps" in refused(
        scene_file(tmp_path), "--experiment", file
    )


def test_what_shows_only_with_the_scene_is_said_of_that_file_too(tmp_path):
    file = tmp_path / "experiment.yaml"
    file.write_text(yaml.safe_dump({"stage": {"second_direction": [0, 1, 0]}}))
    line = refused(scene_file(tmp_path), "--experiment", file)
    assert "experiment.yaml: stage.second_direction: is that of the first" in line


def test_a_folder_of_another_command_stays_as_it_is(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "experiment.json").write_text('{"mine": 1}')
    assert "holds something else (experiment.json)" in refused(scene_file(tmp_path), "-o", out)
    (out / "experiment.json").write_text('{"made_by": "simtip budget"}')
    assert "holds something else (simtip budget)" in refused(scene_file(tmp_path), "-o", out)


def test_scene_and_file_do_not_go_together(tmp_path):
    scene = scene_file(tmp_path)
    assert "give SCENE or --csv FILE" in refused(scene, "--csv", "x.csv")
    assert "--readings: goes with --csv only" in refused(scene, "--readings", "step")
    told = call("mca")
    assert told.code == 2
    assert "give SCENE or --csv FILE" in told.err
    told = call("mca", "--csv", "x.csv", "--workers", "2")
    assert "--workers: goes with a scene only" in told.err


def test_a_folder_of_something_else_stays_as_it_is(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.txt").write_text("precious")
    assert "holds something else (thesis.txt)" in refused(scene_file(tmp_path), "-o", out)
    assert [entry.name for entry in out.iterdir()] == ["thesis.txt"]


def test_a_scene_starts_no_program_by_itself(tmp_path):
    scene = scene_file(tmp_path)
    data = yaml.safe_load(scene.read_text())
    data["detect"] = {"name": "cmd:./mine {image}"}
    scene.write_text(yaml.safe_dump(data))
    assert "may not start a program" in refused(scene)
    data["detect"] = {"name": "dithered:cmd:./mine {image}"}
    scene.write_text(yaml.safe_dump(data))
    assert "may not start a program" in refused(scene)
