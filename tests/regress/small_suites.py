"""Suites of a scene so small that a pair of images takes milliseconds, run as a user runs them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import yaml
from sweep.small_sweeps import scene_file

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


def run(*words: object, cache: Path, code: int = 0, **environment: str) -> tuple[str, str]:
    """Run `simtip regress`, and give what it said on both outputs."""
    here = Path(__file__).resolve().parent
    found = os.environ.get("PYTHONPATH")
    path = os.pathsep.join([str(here), *([found] if found else [])])
    done = subprocess.run(
        [sys.executable, "-m", "simtip", "regress", *map(str, words), "--cache", str(cache)],
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env={**os.environ, "SIMTIP_BACKEND": "llvm", "PYTHONPATH": path, **environment},
    )
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout, done.stderr


def checked(baseline: Path, *options: object, cache: Path, code: int) -> dict:
    """Check a baseline, and give the result."""
    said, _ = run("check", baseline, "--json", *options, cache=cache, code=code)
    return json.loads(said)


def texts(result: dict, state: str) -> list[str]:
    """Give what a result says in words of one state."""
    return [line["text"] for line in result["changes"] if line["state"] == state]
