"""The README's figures are what was measured, not what somebody typed."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def tabulate():
    spec = importlib.util.spec_from_file_location("benchmark_table", FOLDER / "table.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_readme_shows_the_stored_figures(tabulate):
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert tabulate.written(text, tabulate.table(tabulate.stored())) == text


def test_every_benchmark_is_in_the_table_at_full_size(tabulate):
    names = {script.stem.removeprefix("bench_") for script in FOLDER.glob("bench_*.py")}
    assert set(tabulate.ROWS) == names
    for name, result in tabulate.stored().items():
        assert result["benchmark"] == name
        assert result["quick"] is False


def test_a_changed_figure_changes_the_readme(tabulate):
    results = tabulate.stored()
    before = tabulate.table(results)
    results["render"]["ratio"] *= 2
    assert tabulate.table(results) != before
