"""An experiment on a scene so small that it takes seconds."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml
from one_process import call_here

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def scene_file(folder: Path, name: str = "scene.yaml", **experiment: Any) -> Path:
    """Write a scene of two small regions around the way of the tip."""
    data = yaml.safe_load((SCENES / "01_single_tip.yaml").read_text())
    data["rig"]["left"]["roi"] = [770, 760, 100, 250]
    data["rig"]["right"]["roi"] = [983, 755, 100, 250]
    data["render"] = {"noise": None, "samples": 4, "light_step_mm": 4.0}
    data["detect"] = {"name": "lin2020", "min_area_px": 300}
    schedule = {"steps": 4, "runs": 3, "registration": None, **experiment.pop("schedule", {})}
    data["experiment"] = {"schedule": schedule, **experiment}
    path = folder / name
    path.write_text(yaml.safe_dump(data))
    return path


def words(name: str, file: Path, *options: object) -> list[str]:
    """Give the words of an analysis, with a cache beside the scene, that follow the program."""
    return list(map(str, [name, file, "--cache", file.parent / "cache", *options]))


def command(name: str, file: Path, *options: object) -> list[str]:
    """Give its command line."""
    return [sys.executable, "-m", "simtip", *words(name, file, *options)]


def asked(name: str, file: Path, *options: object) -> dict[str, Any]:
    """Run it to its end, workers and all in this process, and give its JSON."""
    done = call_here(*words(name, file, "--json", *options))
    assert done.code == 0, done.err
    found: dict[str, Any] = json.loads(done.out)
    return found


def asked_as_users_do(name: str, file: Path, *options: object) -> dict[str, Any]:
    """Run it to its end in processes of its own, and give its JSON."""
    done = subprocess.run(
        command(name, file, "--json", *options), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found
