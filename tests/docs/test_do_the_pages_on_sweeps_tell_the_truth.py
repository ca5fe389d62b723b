"""Are the sweep of docs/sweeps.md, and the example sweeps, as large as they should be?"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

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
