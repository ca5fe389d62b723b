"""Every benchmark runs and says something; its figures are read by people, not by tests."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"
RENDERING = {"bench_render", "bench_mix", "bench_detect", "bench_run"}
"""These start the renderer; any other, also one written later, has to be quick."""

SCRIPTS = [
    pytest.param(script, id=script.stem, marks=[pytest.mark.slow] * (script.stem in RENDERING))
    for script in sorted(FOLDER.glob("bench_*.py"))
]
ONLY_FIGURES = ("benchmark", "environment", "quick")


@cache
def quick_run(script: Path) -> dict:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script), "--quick"],
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=FOLDER.parent,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)  # one object and nothing else


def figures(value, where=""):
    """Every number in the result, with its place."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from figures(part, f"{where}.{key}")
    elif isinstance(value, list):
        for k, part in enumerate(value):
            yield from figures(part, f"{where}[{k}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield where, value


def test_there_are_benchmarks_to_run():
    assert len(SCRIPTS) >= 6
    assert {f"{name}.py" for name in RENDERING} <= {script.name for script in FOLDER.glob("*.py")}


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS)
def test_it_prints_its_environment_and_finite_positive_figures(script):
    result = quick_run(script)
    assert f"bench_{result['benchmark']}" == script.stem
    assert result["quick"] is True
    where = result["environment"]
    assert where["python"] == sys.version.split()[0]
    assert where["platform"]
    assert where["cpu_count"] >= 1
    for package in ("simtip", "numpy", "opencv-python-headless", "mitsuba"):
        assert where["versions"][package]
    found = dict(figures({k: v for k, v in result.items() if k not in ONLY_FIGURES}))
    assert len(found) >= 5
    for place, value in found.items():
        # what is exactly right, or done in no time, is 0
        least = 0 if "largest_" in place else math.ulp(0)
        assert math.isfinite(value), place
        assert value >= least, place


@pytest.mark.slow
def test_the_render_benchmark_compares_like_with_like():
    result = quick_run(FOLDER / "bench_render.py")
    for key in (
        *("cpu_s_simtip", "cpu_s_path", "ratio"),
        *("noise_background", "noise_flank", "msamples_per_s"),
    ):
        assert result[key] > 0
    assert result["ratio"] == pytest.approx(result["cpu_s_path"] / result["cpu_s_simtip"])
    # The scatter of two seeds over some thousand pixels, against four replicas of each.
    assert result["noise_flank"] == pytest.approx(result["noise_flank_claimed"], rel=0.15)
    # At the smoke run's samples, four standard errors of the means over a few hundred pixels.
    assert result["radiance_simtip_to_path"]["background"] == pytest.approx(1, abs=0.01)
    assert result["radiance_simtip_to_path"]["flank"] == pytest.approx(1, abs=0.04)


@pytest.mark.slow
def test_the_mix_benchmark_really_mixes_by_rows_and_is_cheap_even_on_a_small_view():
    result = quick_run(FOLDER / "bench_mix.py")
    assert result["groups"] == 5
    assert result["rows_differ_by_up_to"] > 0.1
    assert max(result["ratio_to_rendering"].values()) < 0.03
