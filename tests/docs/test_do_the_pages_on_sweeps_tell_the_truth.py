"""Do the commands and files of docs/sweeps.md work as written, and the example sweeps?"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from simtip.sweep.plan import Plan
from simtip.sweep.sweep_file import read_sweep

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
EXAMPLES = sorted((ROOT / "scenes" / "sweeps").glob("*.yaml"))


def blocks(language: str) -> list[str]:
    found = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert found
    return found


def plan_of(file: Path) -> Plan:
    source = read_sweep(file)
    return Plan(source.spec, source.scene)


@pytest.mark.parametrize(
    ("name", "trials", "renders"),
    [
        ("01_threshold_lamp", 330, 1),
        ("02_roughness_lamp_position", 96, 12),
        pytest.param("03_defocus_tip", 60, 10, marks=pytest.mark.slow),
    ],
)
def test_an_example_has_as_many_trials_and_renders_as_it_should(name, trials, renders):
    plan = plan_of(ROOT / "scenes" / "sweeps" / f"{name}.yaml")
    assert len(plan) == trials
    assert len(plan) // plan.block == renders


def test_all_examples_are_counted():
    assert len(EXAMPLES) == 3


def test_the_sweep_file_shown_is_one(tmp_path):
    folder = tmp_path / "scenes" / "sweeps"
    folder.mkdir(parents=True)
    shutil.copy(ROOT / "scenes" / "01_single_tip.yaml", tmp_path / "scenes")
    (folder / "shown.yaml").write_text(blocks("yaml")[0], encoding="utf-8")
    plan = plan_of(folder / "shown.yaml")
    assert len(plan) == 6 * 5 * 2 * 2 * 3 * 3


@pytest.mark.slow
def test_the_commands_run_as_written(tmp_path, monkeypatch):
    """On the scene's needle tip alone, for the whole scene takes a minute."""
    scenes = tmp_path / "scenes"
    (scenes / "sweeps").mkdir(parents=True)
    scene = yaml.safe_load((ROOT / "scenes" / "01_single_tip.yaml").read_text(encoding="utf-8"))
    scene["rig"]["left"]["roi"] = [740, 640, 160, 300]
    scene["rig"]["right"]["roi"] = [950, 640, 160, 300]
    scene["render"] = {"noise": None, "samples": 16}
    (scenes / "01_single_tip.yaml").write_text(yaml.safe_dump(scene), encoding="utf-8")
    shutil.copy(EXAMPLES[0], scenes / "sweeps")
    monkeypatch.setenv("SIMTIP_CACHE", str(tmp_path / "cache"))
    lines = [shlex.split(line, comments=True) for line in blocks("sh")[0].splitlines()]
    for line in lines:
        assert line[0] == "simtip"
        command = [sys.executable, "-m", *line]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{line}: {done.stderr}"
    assert (tmp_path / "few.csv").read_text(encoding="utf-8").count("\n") > 100
