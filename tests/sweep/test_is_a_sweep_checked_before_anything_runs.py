"""Is whatever is wrong with a sweep said before anything runs: field, line, the nearest remedy?"""

import pytest
import yaml
from small_sweeps import scene_file
from typer.testing import CliRunner

from simtip.cli.program import app
from simtip.errors import InputError
from simtip.sweep.plan import Plan
from simtip.sweep.sweep_file import read_sweep


def problem(folder, **said):
    scene_file(folder)
    file = folder / "sweep.yaml"
    file.write_text(yaml.safe_dump({"scene": "scene.yaml", **said}, sort_keys=False))
    with pytest.raises(InputError) as caught:
        planned(file)
    return str(caught.value)


def planned(file):
    source = read_sweep(file)
    try:
        Plan(source.spec, source.scene, (), str(file))
    except InputError as error:
        raise source.located(error) from error


CASES = {
    "a field that is none": (
        {"factors": {"lamps[0].pwer": [1.0]}},
        ["sweep.yaml:3", "lamps[0].pwer", "did you mean 'lamps[0].power'?"],
    ),
    "a lamp that is not there": (
        {"factors": {"lamps[7].power": [1.0]}},
        ["lamps[7].power", "is no field of the scene"],
    ),
    "a value of another type": (
        {"factors": {"sensor.exposure_s": ["long"]}},
        ["sensor.exposure_s", "has to be a number, not the text 'long'"],
    ),
    "a value beyond its range": (
        {"factors": {"sensor.exposure_s": [0.05, -1.0]}},
        ["sensor.exposure_s", "not -1.0"],
    ),
    "a parameter that no detector has": (
        {"factors": {"detect.treshold": [90]}},
        ["detect.treshold", "did you mean detect.threshold?"],
    ),
    "a parameter out of range": (
        {"factors": {"detect.threshold": [90, 900]}},
        ["detect.threshold", "900 is above"],
    ),
    "the detector as a factor": (
        {"factors": {"detect.name": ["lin2020", "subpixel"]}},
        ["list them in detectors"],
    ),
    "a detector that is none": (
        {"detectors": ["lin2021"]},
        ["detectors[0]", "did you mean 'lin2020'?"],
    ),
    "a program in a file": (
        {"detectors": ["cmd:./mine {image}"]},
        ["may not start a program"],
    ),
    "two detectors of one label": (
        {"detectors": ["lin2020", "lin2020"]},
        ["detectors[1]", "label of its own"],
    ),
    "a range without values": (
        {"factors": {"sensor.exposure_s": {"from": 0.01, "to": 0.05}}},
        ["neither count nor step"],
    ),
    "a range backwards": (
        {"factors": {"sensor.exposure_s": {"from": 0.05, "to": 0.01, "count": 3}}},
        ["is not above from"],
    ),
    "the logarithm of nothing": (
        {"factors": {"sensor.exposure_s": {"from": 0, "to": 0.01, "count": 3, "log": True}}},
        ["has no logarithm"],
    ),
    "too many values": (
        {"factors": {"sensor.exposure_s": {"from": 0.01, "to": 0.05, "step": 1e-9}}},
        ["more than 100000 values"],
    ),
    "lists of different length": (
        {"zipped": [{"lamps[0].power": [1.0, 2.0], "lamps[1].power": [1.0]}]},
        ["zipped[0]", "different length"],
    ),
    "a field that varies twice": (
        {"factors": {"lamps[0].power": [1.0]}, "zipped": [{"lamps[0].power": [1.0]}]},
        ["varies twice"],
    ),
    "an unknown key": ({"factor": {}}, ["factor", "is no key of a sweep", "factors"]),
    "no list": ({"factors": {"lamps[0].power": 3}}, ["lamps[0].power", "give a list"]),
    "no repeats": ({"repeats": 0}, ["repeats"]),
    "a scene that is not there": ({"scene": "none.yaml"}, ["none.yaml"]),
    "a base that fits nothing": ({"base": {"sensor.gain": 1.0}}, ["sensor.gain", "did you mean"]),
    "a number that is none": (
        {"factors": {"lamps[0].power": [1.0, float("nan")]}},
        ["sweep.yaml:5", "factors.lamps[0].power[1]: is no number; give a finite number"],
    ),
    "a step of nothing": (
        {"factors": {"lamps[0].power": {"from": 1, "to": 2, "step": 0}}},
        ["factors.lamps[0].power.step: has to be greater than 0"],
    ),
    "a list of nothing": (
        {"factors": {"detect.threshold": []}},
        ["factors.detect.threshold: ", "at least 1 item"],
    ),
    "a name in another spelling": (
        {"factors": {"lamps[00].power": [1.0], "lamps[0].power": [2.0]}},
        ["lamps[00].power: is no plain name; write it 'lamps[0].power'"],
    ),
    "a lamp counted from the end": (
        {"repeats": 2, "factors": {"lamps[-1].power": [1.0]}},
        ["sweep.yaml:4: lamps[-1].power: counts from the end; count from the first"],
    ),
    "a lamp of the base counted from the end": (
        {"repeats": 2, "base": {"render.crop": True, "lamps[-1].power": 1.0}},
        ["sweep.yaml:5: lamps[-1].power: counts from the end"],
    ),
    "no name": (
        {"repeats": 2, "factors": {"": [1.0]}},
        ["sweep.yaml:4: '': names no field"],
    ),
    "the detector's name as a factor": (
        {"repeats": 2, "factors": {"detect.name": ["lin2020"]}},
        ["sweep.yaml:4: detect.name: is varied by detectors"],
    ),
    "a field that varies twice, by its line": (
        {"factors": {"lamps[0].power": [1.0]}, "zipped": [{"lamps[0].power": [1.0]}]},
        ["sweep.yaml:6: zipped[0].lamps[0].power: varies twice"],
    ),
    "a detector's parameter of the base": (
        {"repeats": 2, "base": {"detect.treshold": 90}},
        ["sweep.yaml:4: detect.treshold: ", "did you mean 'threshold'?"],
    ),
    "a field that another kind has": (
        {"factors": {"needle.tip": [{"kind": "bevel", "length_mm": 5}]}},
        ["sweep.yaml:3: needle.tip.length_mm: is nothing that this kind has; leave it out"],
    ),
    "a field that another one does not fit": (
        {"repeats": 2, "factors": {"rig.left.width": [100]}},
        ["sweep.yaml:4: rig.left.width: does not go with rig.left.", "does not lie in"],
    ),
    "more trials than anyone wants": (
        {
            "factors": {
                f"lamps[{k}].{name}": {"from": 1.0, "to": 2.0, "count": 10000}
                for k in (0, 1)
                for name in ("power", "length_mm")
            }
        },
        ["more than 1e+12 trials"],
    ),
}


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(c, marks=[pytest.mark.slow] * (c == "more trials than anyone wants"))
        for c in CASES
    ],
)
def test_what_is_wrong_is_one_line(case, tmp_path):
    given, expected = CASES[case]
    said = problem(tmp_path, **given)
    assert "\n" not in said
    for part in expected:
        assert part in said


def test_a_fault_of_the_scene_names_the_line_in_its_file(tmp_path):
    scene = scene_file(tmp_path)
    scene.write_text(scene.read_text().replace("min_area_px", "min_aera_px"))
    line = 1 + scene.read_text().splitlines().index("  min_aera_px: 300")
    (tmp_path / "sweep.yaml").write_text("scene: scene.yaml\nfactors: {}\n")
    with pytest.raises(InputError) as caught:
        planned(tmp_path / "sweep.yaml")
    assert f"scene.yaml:{line}: detect.min_aera_px: " in str(caught.value)


def test_on_the_command_line_it_is_exit_code_2_and_nothing_is_written(tmp_path, capsys):
    scene_file(tmp_path)
    file = tmp_path / "sweep.yaml"
    file.write_text("scene: scene.yaml\nfactors: {detect.treshold: [1]}\n")
    from simtip.cli import main

    with pytest.raises(SystemExit) as caught:
        main(["sweep", str(file), "-o", str(tmp_path / "out")])
    assert caught.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "sweep.yaml:2" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--detector", ""], "--detector: is empty"),
        (
            ["--detector", "cmd:./nowhere {image}"],
            "--detector: ./nowhere cannot be started: no such file; name a program that is there",
        ),
        (
            ["--dry-run", "--detector", "lin2020", "--detector", "cmd:no-such-program {image}"],
            "--detector: no-such-program cannot be started: no such program in PATH",
        ),
        (
            ["--detector", "lin2020", "--detector", "lin2020"],
            "--detector: names 'lin2020' twice; name it once",
        ),
        (["--scheduler", "foo"], "--scheduler: 'foo' is no address; write e.g. tcp://host:8786"),
        (["--scheduler", "tcp://a:1", "--workers", "2"], "--workers: is the cluster's affair"),
    ],
)
def test_options_that_cannot_be(options, said, tmp_path):
    file = tmp_path / "sweep.yaml"
    scene_file(tmp_path)
    file.write_text("scene: scene.yaml")
    done = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out"), *options])
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("more", [[], ["--dry-run"]])
@pytest.mark.parametrize(
    ("name", "said"), [("other", "holds something else (photo.png)"), ("file", "file: cannot be")]
)
def test_a_folder_that_cannot_be_is_said_by_a_dry_run_too(name, said, more, tmp_path):
    scene_file(tmp_path)
    (tmp_path / "sweep.yaml").write_text("scene: scene.yaml")
    (tmp_path / "file").touch()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "photo.png").touch()
    words = ["sweep", str(tmp_path / "sweep.yaml"), "-o", str(tmp_path / name), *more]
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)


@pytest.mark.parametrize("text", ["[]", "3", "", "{", "scene: !!python/name:os.system"])
def test_a_file_that_is_no_sweep(text, tmp_path):
    file = tmp_path / "sweep.yaml"
    file.write_text(text)
    done = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out")])
    assert isinstance(done.exception, InputError)
    assert "sweep.yaml" in str(done.exception)
