"""Are files made of the keys that docs/reference/file_formats.md tells of, and of no others?"""

from __future__ import annotations

import json
import re

import pytest
from pages import ROOT

from simtip.result_folder import write_manifest, write_simulation, write_trial
from simtip.sweep.columns import FIXED
from simtip.trial import run_trial

PAGE = (ROOT / "docs" / "reference" / "file_formats.md").read_text(encoding="utf-8")
GLOSSARY = (ROOT / "docs" / "reference" / "glossary.md").read_text(encoding="utf-8")
NAME = re.compile(r"`(\w+)`")

ONLY_SOMETIMES = {"clutter"}
"""Keys of `truth.json` that a scene without solid clutter does not have."""


def told(heading: str, table: int = 0) -> dict[str, set[str]]:
    """Give the keys of a section's table, each with all names of its row's second cell."""
    section = PAGE.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    rows = re.findall(r"((?:^\|.*\n)+)", section, re.MULTILINE)[table].splitlines()[2:]
    cells = [row.strip("|").split("|") for row in rows]
    return {
        key: set(NAME.findall(second)) for first, second in cells for key in NAME.findall(first)
    }


@pytest.fixture(scope="module")
def folder(small_scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("result")
    # Of the needle, the region shows less than the paper's least area.
    seen = small_scene.detect.model_copy(update={"min_area_px": 300})
    trial = run_trial(small_scene.model_copy(update={"detect": seen}))
    assert trial.ok
    write_simulation(folder, trial.simulation)
    write_trial(folder, trial)
    write_manifest(folder, trial.simulation, trial.to_dict()["timings_s"])
    return folder


@pytest.mark.parametrize("name", ["truth.json", "result.json", "manifest.json"])
def test_a_file_has_the_keys_that_are_told(name, folder):
    found = json.loads((folder / name).read_text(encoding="utf-8"))
    assert set(found) == set(told(name)) - ONLY_SOMETIMES


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("truth.json", "needle"),
        ("truth.json", "left"),
        ("result.json", "error_mm"),
        ("manifest.json", "backend"),
        ("manifest.json", "noise"),
    ],
)
def test_so_has_what_is_within(name, key, folder):
    found = json.loads((folder / name).read_text(encoding="utf-8"))[key]
    within = set(found) | set(found.get("left", {})) | set(found.get("T_wn", {}))
    assert within - {"left", "right"} == told(name)[key] - {"left", "right"}


def test_a_table_has_the_columns_that_are_told():
    columns = set(told("Table of a sweep"))
    columns |= {name.replace("left", "right") for name in columns if name.startswith("left_")}
    columns |= told("Table of a sweep")["error_x_mm"]
    assert columns == {column.name for column in FIXED}


@pytest.mark.parametrize(("name", "table"), [("experiment", 0), ("budget", 1)])
def test_analyses_have_the_keys_that_are_told(name, table):
    stored = (ROOT / "benchmarks" / "figures" / "paper.json").read_text(encoding="utf-8")
    assert set(json.loads(stored)[name]) == set(told("mca.json and budget.json", table))


def test_the_glossary_is_in_order_and_tells_each_term_once():
    terms = [row.split("|")[1].strip().lower() for row in GLOSSARY.splitlines()[4:]]
    assert terms == sorted(set(terms))
