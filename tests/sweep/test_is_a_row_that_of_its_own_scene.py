"""Is every row what its own scene gives, whatever else the sweep varies and whatever was kept?"""

import ast
import sys
from pathlib import Path

import pytest
import yaml
from small_sweeps import rows, run, scene_file, summary, sweep_file
from typer.testing import CliRunner

from simtip.cli.program import app
from simtip.errors import InputError
from simtip.light_inputs import light_digest
from simtip.sweep import stage_keys
from simtip.sweep.leaving import ToldToLeaveError
from simtip.sweep.plan import Plan
from simtip.sweep.shots import Shot
from simtip.sweep.sweep_file import read_sweep


def plan_of(folder, **said):
    scene_file(folder)
    file = folder / "sweep.yaml"
    file.write_text(yaml.safe_dump({"scene": "scene.yaml", **said}, sort_keys=False))
    source = read_sweep(file)
    return Plan(source.spec, source.scene)


def test_the_light_is_that_of_the_trial_where_fields_depend_on_each_other(tmp_path):
    """An aperture means nothing to a pinhole's light, and much to a lens's."""
    factors = {
        "rig.left.lens.focus_mm": [None, 140.0],
        "rig.left.lens.f_number": [1.4, 5.6],
        "sensor.exposure_s": [0.04, 0.05],
    }
    plan = plan_of(tmp_path, factors=factors)
    for number in range(len(plan)):
        trial = plan.trial(number)
        own = plan.scenes.with_values(trial.values)
        assert light_digest(plan.reference(trial)) == light_digest(own)


def test_the_noise_asked_for_is_another_light(tmp_path):
    plan = plan_of(tmp_path, factors={"render.noise": [0.3, 3.0]})
    assert [plan.reference(plan.trial(k)).render.noise for k in (0, 1)] == [0.3, 3.0]


@pytest.mark.parametrize("design", [None, {"kind": "random", "points": 32}])
def test_no_two_trials_have_one_key(tmp_path, design):
    said = {} if design is None else {"design": design}
    spread = {"from": 60, "to": 63} if design else {"from": 60, "to": 63, "count": 4}
    plan = plan_of(tmp_path, factors={"detect.threshold": spread}, repeats=2, **said)
    assert len({plan.key(plan.trial(k)) for k in range(len(plan))}) == len(plan)


def test_equal_levels_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"detect.threshold: has 80 twice; name each value once"):
        plan_of(tmp_path, factors={"detect.threshold": [80, 80, 100]})


@pytest.mark.slow
def test_a_detector_knows_what_white_is_at_every_bit_depth(tmp_path):
    """12-bit images of 16 times the gain are the same images: so are the tips."""
    zipped = [{"sensor.bit_depth": [8, 12], "sensor.gain_dn_per_e": [0.0255, 0.408]}]
    file = sweep_file(tmp_path, factors={}, zipped=zipped, detectors=["lin2020", "subpixel"])
    summary(file, tmp_path / "out")
    found = rows(tmp_path / "out")
    assert list(found.status) == ["ok"] * 4
    assert found.error_norm_mm.max() < 1


@pytest.mark.slow
def test_a_rig_whose_file_has_changed_measures_anew(tmp_path):
    scene = scene_file(tmp_path)
    rig = tmp_path / "rig.yaml"
    assert CliRunner().invoke(app, ["rig", str(scene), "-o", str(rig)]).exit_code == 0
    file = sweep_file(tmp_path, factors={}, base={"rig.measured": "rig.yaml"})
    assert summary(file, tmp_path / "out")["done"] == 1
    before = rows(tmp_path / "out").tip_z_mm[0]
    assert summary(file, tmp_path / "out")["done"] == 0
    text = rig.read_text()
    assert "-69.266" in text  # the baseline along x
    rig.write_text(text.replace("-69.266", "-72.729"))
    assert summary(file, tmp_path / "out")["done"] == 1
    assert rows(tmp_path / "out").tip_z_mm[0] > before + 1


@pytest.mark.slow
def test_a_rig_that_is_not_there_is_said_at_once(tmp_path):
    file = sweep_file(tmp_path, factors={"rig.measured": ["gone.yaml"]})
    said = run(file, tmp_path / "out", "--dry-run", code=2)
    assert "gone.yaml" in said


DETECTOR = """
from helper import THRESHOLD
from simtip.detect import configure

def find(image):
    return configure("lin2020", {"threshold": THRESHOLD, "min_area_px": 300})(image)
"""


@pytest.mark.slow
def test_a_detector_that_has_changed_measures_anew(tmp_path, monkeypatch):
    """The module itself is the same: what it imports has changed."""
    (tmp_path / "my_detector.py").write_text(DETECTOR)
    (tmp_path / "helper.py").write_text("THRESHOLD = 105\n")
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)
    file = sweep_file(tmp_path, factors={})
    options = ("--detector", "my_detector:find")
    assert summary(file, tmp_path / "out", *options)["worked_out"]["measure"] == 1
    before = rows(tmp_path / "out")
    assert summary(file, tmp_path / "out", *options)["done"] == 0
    (tmp_path / "helper.py").write_text("THRESHOLD = 60\n")
    for name in ("my_detector", "helper"):  # as in another process
        monkeypatch.delitem(sys.modules, name)
    again = summary(file, tmp_path / "out", *options)
    assert again["worked_out"] == {"light": 0, "images": 0, "measure": 1}
    after = rows(tmp_path / "out")
    assert after.tip_z_mm[0] != before.tip_z_mm[0]
    assert after.code[0] != before.code[0]


@pytest.mark.parametrize("reference", ["sys:intern", "cmd:./mine {image}"])
def test_of_some_detectors_nobody_knows_whether_they_change(reference):
    assert stage_keys.detector_code(reference) is None


def test_repeats_have_noise_of_their_own(tmp_path):
    from simtip.render import choose
    from simtip.sweep.limit import Limit
    from simtip.sweep.stages import Stages

    plan = plan_of(tmp_path, repeats=3)
    stages = Stages(plan, None, choose("llvm"), Limit(60))
    assert len({stages.setting(plan.trial(k)).seed for k in range(3)}) == 3


@pytest.fixture
def ending(tmp_path, monkeypatch):
    """Give the row of a trial whose images make the detector raise something."""
    from simtip.render import choose
    from simtip.sweep.limit import Limit
    from simtip.sweep.stages import Stages

    plan = plan_of(tmp_path)
    stages = Stages(plan, None, choose("llvm"), Limit(60))

    def row(error):
        def measured(*_, **__):
            raise error

        monkeypatch.setattr(stages, "_shot", lambda *_: Shot((None, None), 0.04))
        monkeypatch.setattr("simtip.sweep.stages.measured", measured)
        return stages.row(plan.trial(0))

    return row


def test_an_interrupt_by_a_detector_is_a_row(ending):
    row = ending(KeyboardInterrupt("mine"))
    assert (row["status"], row["reason"]) == ("error", "KeyboardInterrupt: mine")


def test_of_a_trial_that_is_left_there_is_no_row(ending):
    with pytest.raises(ToldToLeaveError):
        ending(ToldToLeaveError())


PACKAGE = stage_keys.PACKAGE
ELSEWHERE = {
    *("input_file", "output_folder", "image_file", "scene_error", "scene_range", "scene_file"),
    "provenance",
}
"""Reading, writing, refusing: nothing that comes out depends on them."""

OF_BOARDS = {"plate", "target", "bound", "bound_file"}
"""Calibration boards, and efficiency, which rows do not have."""


def imports(file):
    """Give the files of simtip that a file imports, but for the types alone."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for part in ast.walk(tree):
        if isinstance(part, ast.If) and "TYPE_CHECKING" in ast.dump(part.test):
            part.body = []
    for part in ast.walk(tree):
        names = []
        if isinstance(part, ast.ImportFrom) and part.module and not part.level:
            names = [part.module, *(f"{part.module}.{one.name}" for one in part.names)]
        elif isinstance(part, ast.Import):
            names = [one.name for one in part.names]
        for name in names:
            place = PACKAGE.parent / Path(*name.split("."))
            if name.startswith("simtip."):
                yield from (
                    p for p in (place.with_suffix(".py"), place / "__init__.py") if p.is_file()
                )


def files(modules):
    for name in modules:
        place = PACKAGE / name
        yield from place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]


@pytest.mark.parametrize(
    "stage",
    [*(pytest.param(s, marks=pytest.mark.slow) for s in ("LIGHT", "IMAGES")), "MEASURE"],
)
def test_all_code_that_a_stage_imports_is_in_its_key(stage):
    stages = ("LIGHT", "IMAGES", "MEASURE")
    known = [getattr(stage_keys, one) for one in stages[: stages.index(stage) + 1]]
    have = {file for modules in known for file in files(modules)}
    begun = [one for one in getattr(stage_keys, stage) if not one.startswith("sweep/")]
    todo, seen = list(files(begun)), set()
    while todo:
        file = todo.pop()
        if file not in seen:
            seen.add(file)
            if file in have:
                todo += imports(file)
    missing = {file.relative_to(PACKAGE).parts[0].removesuffix(".py") for file in seen - have}
    assert missing <= ELSEWHERE | OF_BOARDS | {"version"}
