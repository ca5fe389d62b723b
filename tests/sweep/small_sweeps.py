"""Sweeps of a scene so small that a trial takes milliseconds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import yaml
from one_process import call_here

from simtip.sweep.table import Table

SCENES = Path(__file__).resolve().parents[2] / "scenes"
TIMINGS = ["render_s", "sensor_s", "detect_s"]

FACTORS = {
    "needle.roll_deg": [0.0, 40.0],
    "lamps[0].power": [1.0, 1.2],
    "sensor.exposure_s": {"from": 0.04, "to": 0.05, "count": 2},
    "detect.threshold": {"from": 60, "to": 120, "count": 4},
}


def scene_file(folder: Path) -> Path:
    """Write a scene of two small regions around the tip."""
    data = yaml.safe_load((SCENES / "01_single_tip.yaml").read_text())
    data["rig"]["left"]["roi"] = [770, 760, 100, 150]
    data["rig"]["right"]["roi"] = [983, 755, 100, 150]
    data["render"] = {"noise": None, "samples": 4, "light_step_mm": 4.0}
    data["detect"] = {"name": "lin2020", "min_area_px": 300}
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


def sweep_file(folder: Path, **said: object) -> Path:
    """Write a sweep of that scene."""
    scene_file(folder)
    path = folder / "sweep.yaml"
    path.write_text(yaml.safe_dump({"scene": "scene.yaml", "factors": FACTORS, **said}))
    return path


def words(file: Path, out: Path, *options: object, cache: Path | None = None) -> list[str]:
    """Give the words of a sweep's command line that follow the program."""
    kept = ["--cache", str(cache or file.parent / "cache")]
    return [*map(str, ["sweep", file, "-o", out, *kept, *options])]


def command(file: Path, out: Path, *options: object, cache: Path | None = None) -> list[str]:
    """Give the command line of a sweep."""
    return [sys.executable, "-m", "simtip", *words(file, out, *options, cache=cache)]


def run(file: Path, out: Path, *options: object, cache: Path | None = None, code: int = 0) -> str:
    """Run a sweep to its end, workers and all in this process; give what it said."""
    done = call_here(*words(file, out, *options, cache=cache))
    assert done.code == code, done.err
    return done.out + done.err


def summary(file: Path, out: Path, *options: object, cache: Path | None = None) -> dict:
    """Run a sweep to its end in this process, and give its own summary."""
    return _summary(run(file, out, "--json", *options, cache=cache))


def summary_as_users_do(
    file: Path, out: Path, *options: object, cache: Path | None = None, **environment: str
) -> dict:
    """Run a sweep to its end in processes of its own, and give its own summary."""
    done = subprocess.run(
        command(file, out, "--json", *options, cache=cache),
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env={**os.environ, "SIMTIP_BACKEND": "llvm", **environment},
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return _summary(done.stdout)


def _summary(said: str) -> dict:
    return json.loads(next(line for line in said.splitlines() if line.startswith("{")))


def rows(out: Path) -> pd.DataFrame:
    """Read a sweep's rows, without the timings."""
    return Table.open(out).frame().drop(columns=TIMINGS)


def assert_same_rows(out: Path, expected: Path) -> None:
    """Check that two sweeps have the same rows, bit for bit."""
    pd.testing.assert_frame_equal(rows(out), rows(expected), check_exact=True)
