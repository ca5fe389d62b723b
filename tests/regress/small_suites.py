"""Suites of a scene so small that a pair of images takes milliseconds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

import yaml
from one_process import call_here
from sweep.small_sweeps import scene_file

from simtip.regress.timing import Asked, Ratio

SCENES = Path(__file__).resolve().parents[2] / "scenes"

CASES = [
    {"name": "nominal"},
    {"name": "lamps", "factors": {"lamps[0].power": [0.8, 1.2]}},
    {"name": "rolled", "base": {"needle.roll_deg": 40.0}},
]


def suite_file(folder: Path, **said: object) -> Path:
    """Write a suite of that scene."""
    scene_file(folder)
    path = folder / "suite.yaml"
    whole = {"name": "small", "scene": "scene.yaml", "repeats": 12, "cases": CASES, **said}
    path.write_text(yaml.safe_dump(whole))
    return path


def fixed_ratio(_: Asked) -> Ratio:
    """Stand in for the timing of a detector, which takes longer than all else of a check."""
    return Ratio(0.5, 0.01)


def run(*words: object, cache: Path, code: int = 0, **environment: str) -> tuple[str, str]:
    """Call `simtip regress`, workers and all, with a clock that always says the same.

    Returns
    -------
    out, err
        What it said.
    """
    with mock.patch("simtip.regress.timing.ratio_of", fixed_ratio):
        done = call_here("regress", *words, "--cache", cache, **environment)
    assert done.code == code, done.out + done.err
    return done.out, done.err


def run_as_users_do(*words: object, cache: Path, code: int = 0) -> str:
    """Run `simtip regress` in processes of its own, which are timed, and give its output."""
    here = Path(__file__).resolve().parent
    found = os.environ.get("PYTHONPATH")
    path = os.pathsep.join([str(here), *([found] if found else [])])
    done = subprocess.run(
        [sys.executable, "-m", "simtip", "regress", *map(str, words), "--cache", str(cache)],
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env={**os.environ, "SIMTIP_BACKEND": "llvm", "PYTHONPATH": path},
    )
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def checked(baseline: Path, *options: object, cache: Path, code: int) -> dict:
    """Check a baseline, and give the result."""
    said, _ = run("check", baseline, "--json", *options, cache=cache, code=code)
    return json.loads(said)


def texts(result: dict, state: str) -> list[str]:
    """Give what a result says in words of one state."""
    return [line["text"] for line in result["changes"] if line["state"] == state]
