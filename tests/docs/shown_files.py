"""Files that the documentation shows, held against what they have to be."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import yaml
from pages import ROOT, Block

from simtip.regress.suite import read_suite
from simtip.scene_file import load_scene
from simtip.sweep.plan import Plan
from simtip.sweep.sweep_file import read_sweep

BASE = ROOT / "scenes" / "01_single_tip.yaml"
"""What a part of a scene is a part of."""


def check(block: Block, folder: Path) -> str:
    """Read a block as what it is, and say what that is."""
    if block.language == "json":
        json.loads(block.text)
    elif block.language == "toml":
        tomllib.loads(block.text)
    else:
        data = yaml.safe_load(block.text)
        if isinstance(data, list):  # steps of a job, which alone are lists
            data = {"jobs": {"job": {"steps": data}}}
        assert isinstance(data, dict), f"{block.place}: is no mapping"
        path = folder / (block.file or "shown.yaml")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")
        return check_mapping(data, path)
    return block.language


def check_mapping(data: dict[str, Any], path: Path) -> str:
    """Read a YAML file as what it is.

    A mapping with jobs is a CI's workflow, one with cases a suite, one with a scene a sweep; with a
    rig's two cameras it is a scene, else a part of one.
    """
    if "jobs" in data:
        steps = [step for job in data["jobs"].values() for step in job["steps"]]
        assert all({"run", "uses"} & set(step) for step in steps)
        return "workflow"
    if "cases" in data:
        read_suite(path)
        return "suite"
    if "scene" in data:
        source = read_sweep(path)
        Plan(source.spec, source.scene)
        return "sweep"
    if "left" in data.get("rig", {}):
        load_scene(path)
        return "scene"
    base = yaml.safe_load(BASE.read_text(encoding="utf-8"))
    path.write_text(yaml.safe_dump(merged(base, data)), encoding="utf-8")
    load_scene(path)
    return "part of a scene"


def merged(base: Any, part: Any) -> Any:
    """Put a part over a base, key by key; what has a kind is whole."""
    if isinstance(base, dict) and isinstance(part, dict) and "kind" not in part:
        return base | {key: merged(base.get(key), value) for key, value in part.items()}
    return part
