"""Does every command and code block of the README run as written?"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from regions import with_roi

from simtip.cli import app
from simtip.scene_file import dump_scene
from simtip.spec import SceneSpec
from simtip.spec.experiment import ExperimentSpec, ScheduleSpec, StageSpec

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MARKDOWN = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(language: str) -> list[str]:
    found = re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    assert found
    return found


def commands() -> list[list[str]]:
    """Give the lines of the "Use" section, as a shell would split them."""
    lines = [line.split("#")[0].strip() for block in blocks("sh") for line in block.splitlines()]
    return [shlex.split(line) for line in lines if line.startswith("simtip ")]


def test_every_command_is_shown():
    assert {command[1] for command in commands()} == {
        *(command.name or command.callback.__name__ for command in app.registered_commands),
        *(group.name for group in app.registered_groups),
    }


def test_the_scene_shown_is_a_scene():
    scenes = [SceneSpec.model_validate(yaml.safe_load(block)) for block in blocks("yaml")]
    assert scenes[0].needle.tip.kind == "bevel"


def test_the_make_targets_shown_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^make (\w+)", "\n".join(blocks("sh")), re.MULTILINE)
    assert targets == ["demo", "test"]
    assert all(f"\n{target}:" in makefile for target in targets)


@pytest.mark.parametrize("page", MARKDOWN, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert not missing


def test_every_test_that_the_docs_name_exists():
    for page in MARKDOWN:
        for name in re.findall(r"`(tests/[\w/.]+)", page.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{page.name} names {name}"


SHORT = ExperimentSpec(
    stage=StageSpec(stroke_mm=(2, 1, 1)),
    schedule=ScheduleSpec(steps=4, step_mm=0.5, runs=2, registration=None),
)
"""An experiment that a region around the tip has room for."""


def quarter(scene: SceneSpec) -> SceneSpec:
    """Give the scene with a quarter of the pixels each way, for quick pictures of whole boards."""
    data = scene.model_dump(mode="json")
    for camera in (data["rig"]["left"], data["rig"]["right"]):
        for key in ("fx", "fy", "cx", "cy"):
            camera[key] /= 4
        for key in ("width", "height"):
            camera[key] //= 4
    data["sensor"]["pixel_um"] *= 4
    data["sensor"]["exposure_s"] /= 16
    data["render"] |= {"samples": 16, "noise": None}
    return SceneSpec.model_validate(data)


@pytest.mark.slow
def test_the_commands_run_as_written(tmp_path, scene, monkeypatch):
    small = with_roi(scene, [740, 640, 160, 300], [950, 640, 160, 300])
    # Of the needle, the region shows less than the paper's least area.
    seen = small.detect.model_copy(update={"min_area_px": 1000})
    small = small.model_copy(update={"experiment": SHORT, "detect": seen})
    (tmp_path / "SCENE").write_text(dump_scene(small), encoding="utf-8")
    dimmed = dump_scene(small).replace("power: 1.0", "power: 0.5", 1)
    (tmp_path / "SCENE2").write_text(dimmed, encoding="utf-8")
    sweep = {"scene": "SCENE", "factors": {"detect.threshold": [90, 105]}}
    (tmp_path / "SWEEP").write_text(yaml.safe_dump(sweep), encoding="utf-8")
    rows = [f"{p},{o},{t},{2 * p},{2 * p + 0.29 + 0.01 * t + 0.02 * o}"
            for p in range(1, 6) for o in range(2) for t in range(3)]  # fmt: skip
    table = "\n".join(["part,operator,trial,reference,measured", *rows])
    (tmp_path / "CSV").write_text(table, encoding="utf-8")
    monkeypatch.setenv("SIMTIP_CACHE", str(tmp_path / "cache"))
    (tmp_path / "BOARDS").write_text(dump_scene(quarter(scene)), encoding="utf-8")
    simtip = [sys.executable, "-m", "simtip"]
    for k, command in enumerate(commands()):
        line = command[1:]
        if line[0] == "remix":  # what the command before it rendered
            line[1] = f"DIR{k - 1}"
        if line[0] == "boards":  # few, small and quick ones
            line[1] = "BOARDS"
            line[line.index("20")] = "4"
        if line[0] == "bound":
            line[2:2] = ["--samples", "16"]
        if line[0] == "calibrate":  # what the command before it rendered
            line[1] = f"DIR{k - 1}"
        if line[0] in {"export", "view"}:  # what the first command made
            line[1] = "DIR0"
        if line[0] == "measure":  # on the images that the first command made
            shutil.copy(tmp_path / "DIR0" / "left.png", tmp_path / "left.png")
            shutil.copy(tmp_path / "DIR0" / "right.png", tmp_path / "right.png")
        if "-o" in line and line[line.index("-o") + 1].startswith("DIR"):
            line[line.index("-o") + 1] = f"DIR{k}"
        into = line.index(">") if ">" in line else len(line)
        done = subprocess.run(
            [*simtip, *line[:into]], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{command}: {done.stderr}"
        if into < len(line):  # a later command may read it
            (tmp_path / line[into + 1]).write_text(done.stdout, encoding="utf-8")


@pytest.mark.slow
def test_the_python_shown_runs_as_written(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    for block in blocks("python"):
        exec(compile(block, "README.md", "exec"), {})  # noqa: S102 (our own README)
    assert capsys.readouterr().out.startswith("ok ")
