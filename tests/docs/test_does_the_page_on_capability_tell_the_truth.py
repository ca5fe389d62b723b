"""Does what docs/capability.md and docs/paper.md show work, and is what they say so?"""

from __future__ import annotations

import importlib
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from simtip.budget.causes import WITHOUT
from simtip.scene_file import load_scene
from simtip.spec.experiment import ExperimentSpec

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "capability.md").read_text(encoding="utf-8")
PAPER = ROOT / "scenes" / "paper" / "lin2020.yaml"


def block(language):
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


def test_the_experiment_shown_is_one():
    shown = yaml.safe_load(block("yaml"))["experiment"]
    spec = ExperimentSpec.model_validate_json(json.dumps(shown), strict=True)
    # What it shows as the default is one.
    plain = ExperimentSpec()
    assert spec.interferometer == plain.interferometer
    assert spec.schedule == plain.schedule
    assert spec.tolerance_mm == plain.tolerance_mm


def test_the_causes_shown_are_all_there_are():
    for cause in WITHOUT:
        assert f"| {cause} |" in PAGE


def test_the_papers_scene_has_the_papers_rig(table_1):
    scene = load_scene(PAPER)
    rig = scene.rig.rig()
    for ours, theirs in ((rig.left, table_1.left), (rig.right, table_1.right)):
        assert np.allclose(ours.K, theirs.K)
    assert np.allclose(rig.T_lr.matrix(), table_1.T_lr.matrix())
    assert scene.detect.name == "lin2020"
    assert scene.needle.diameter_mm == pytest.approx(1.67)
    schedule = scene.experiment.schedule
    assert (schedule.steps, schedule.step_mm, schedule.runs) == (14, 2.0, 5)


@pytest.mark.parametrize("name", ["figures", "budget"])
def test_the_papers_tables_are_the_measured_ones(name, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    paper = importlib.import_module("paper")
    told = json.loads(paper.STORED.read_text(encoding="utf-8"))
    table = {"figures": paper.figures_table, "budget": paper.budget_table}[name](told)
    assert table in paper.PAGE.read_text(encoding="utf-8")


def test_the_papers_figures_come_out_within_a_factor_of_one_and_a_half():
    told = json.loads((ROOT / "benchmarks" / "figures" / "paper.json").read_text())["experiment"]
    accuracy, agreement = told["accuracy"], told["agreement"]
    for ours, theirs in (
        (accuracy["mean_abs_mm"], 0.2824),
        (accuracy["max_abs_mm"], 0.3621),
        (agreement["bias_mm"], 0.29),
        (told["repeatability"]["p_t_percent"], 16.42),
    ):
        assert theirs / 1.5 < ours < theirs * 1.5
