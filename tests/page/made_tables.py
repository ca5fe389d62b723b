"""Tables of sweeps made by hand, and pages of them, quick enough for a test."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import yaml

from simtip.page.folder import results_in
from simtip.page.html import html_of
from simtip.page.make import page_of
from simtip.page.options import Options
from simtip.sweep.columns import Column, columns_for
from simtip.sweep.table import Table

SCENES = Path(__file__).resolve().parents[2] / "scenes"

HOSTILE = (
    "</script><script>alert(1)</script>\"'&<img src=x onerror=alert(2)>\u2028$x$ " + "long " * 40
)
"""What no page may take for anything but text."""


def scene_data(**parts) -> dict:
    """Give a scene of two small regions around the tip."""
    data = yaml.safe_load((SCENES / "01_single_tip.yaml").read_text())
    data["rig"]["left"]["roi"] = [770, 760, 100, 150]
    data["rig"]["right"]["roi"] = [983, 755, 100, 150]
    data["render"] = {"noise": None, "samples": 4, "light_step_mm": 4.0}
    data["detect"] = {"name": "lin2020", "min_area_px": 300}
    return data | parts


def provenance(trials: int, factors: dict, detectors: list | None = None, **scene) -> dict:
    sweep = {"scene": "scene.yaml", "factors": factors}
    if detectors is not None:
        sweep["detectors"] = detectors
    said = {"sweep": json.dumps(sweep), "scene": json.dumps(scene_data(**scene))}
    return {
        "trials": trials,
        "simtip": "0.1.0",
        "python": "3.11",
        "packages": {"numpy": "2"},
        **said,
    }


def row(k: int, error_mm: float | None = 0.1, **more) -> dict[str, object]:
    """Give the row of trial `k`: its errors in proportion, or none with its status."""
    names = [f"error_{axis}_mm" for axis in "xyz"]
    views = [
        f"{side}_error_{way}_px"
        for side in ("left", "right")
        for way in ("u", "v", "along", "across")
    ]
    errors: dict[str, object] = dict.fromkeys([*names, *views, "error_norm_mm"])
    if error_mm is not None:
        errors |= dict(zip(names, (error_mm * 0.6, -error_mm * 0.8, 0.0), strict=True))
        errors |= dict.fromkeys(views, 10 * error_mm)
        errors["error_norm_mm"] = error_mm
    ok = {"status": "ok", "reason": ""} if error_mm is not None else {
        "status": "left_touches_border", "reason": "left: it touches the border"
    }  # fmt: skip
    said = {"key": hashlib.sha256(b"%d" % k).hexdigest(), "trial": k, "repeat": 0}
    return {
        **said,
        "detector": "lin2020",
        "noise_seed": k,
        "detect_s": 0.01,
        **errors,
        **ok,
        **more,
    }


def make(folder: Path, columns: list[tuple[str, str]], rows: list[dict], **said) -> Path:
    """Write a sweep's folder."""
    factors = {name: [0] for name, _ in columns}
    about = provenance(said.pop("planned", len(rows)), said.pop("factors", factors), **said)
    table = Table.create(folder, columns_for(Column(*one) for one in columns), about)
    table.append(rows)
    return folder


def grid(folder: Path, *, repeats: int = 3, **said) -> Path:
    """Write a sweep over threshold and power: some cells fail, the error grows with both."""
    rng = np.random.default_rng(3)
    rows = []
    for threshold in range(60, 160, 20):
        for power in (0.5, 1.0, 1.5, 2.25):
            for repeat in range(repeats):
                for label in ("lin2020", "other"):
                    base = 0.05 + 0.002 * (threshold - 60) + 0.05 * power
                    error = float(base * rng.uniform(0.9, 1.1) * (2 if label == "other" else 1))
                    lost = threshold == 140 and power > 1 and repeat == 0
                    more = {"detect.threshold": threshold, "lamps[0].power": power}
                    one = row(
                        len(rows), None if lost else error, repeat=repeat, detector=label, **more
                    )
                    rows.append(one)
    columns = [("detect.threshold", "int"), ("lamps[0].power", "float")]
    factors = {"detect.threshold": [60, 80, 100, 120, 140], "lamps[0].power": [0.5, 1.0, 1.5, 2.25]}
    detectors = ["lin2020", {"name": "lin2020", "label": "other"}]
    return make(folder, columns, rows, factors=factors, detectors=detectors, **said)


def page(folder: Path, **options) -> str:
    """Give a folder's page."""
    return html_of(page_of(results_in(folder), Options(**{"pictures": 0, **options})))


def written(folder: Path, **options) -> Path:
    """Write a folder's page beside it."""
    file = folder.parent / f"{folder.name}.html"
    file.write_text(page(folder, **options), encoding="utf-8")
    return file
