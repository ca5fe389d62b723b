"""Scenes cut down so that the commands of the documentation take seconds.

This is all in which a test's run differs from a reader's: the scenes of the reader's folder have
fewer pixels and samples, and `smaller` and `quicker` of `shell` change a few options.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from simtip.scene_file import dump_scene, load_scene
from simtip.spec import SceneSpec
from simtip.truth import scene_truth

QUICK = {"samples": 16, "noise": None, "light_step_mm": 4.0, "crop": False}
"""Of `render`."""

MIN_AREA_PX = 300
"""Of `lin2020`: a region shows less of the needle than the paper's least area."""

EXPERIMENT: dict[str, Any] = {
    "stage": {"stroke_mm": [4, 1, 1]},
    "schedule": {"steps": 3, "step_mm": 1, "runs": 2, "registration": None},
}
"""One that a region around the tip has room for."""

BEFORE_PX, AFTER_PX, ASIDE_PX = 110, 60, 50
"""Of a region, from the tip: back along the needle (up), ahead of it, and to each side."""


def region(scene: SceneSpec) -> SceneSpec:
    """Read out the surroundings of the tip alone, with few samples."""
    truth = scene_truth(scene)
    data = quick(scene)
    for side, tip in (("left", truth.left.tip_px), ("right", truth.right.tip_px)):
        camera = data["rig"][side]
        corner = camera["roi"][:2] if camera["roi"] else (0, 0)
        u, v = np.rint(tip).astype(int) + corner
        low = max(u - ASIDE_PX, 0), max(v - BEFORE_PX, 0)
        high = (
            min(u + ASIDE_PX, camera["width"]),
            min(v + AFTER_PX, camera["height"]),
        )
        camera["roi"] = [int(n) for n in (*low, high[0] - low[0], high[1] - low[1])]
    if data["detect"]["name"] == "lin2020":
        data["detect"]["min_area_px"] = MIN_AREA_PX
    return SceneSpec.model_validate(data)


def quarter(scene: SceneSpec) -> SceneSpec:
    """Give the scene with a quarter of the pixels each way, for quick pictures of whole boards."""
    data = quick(scene)
    for camera in (data["rig"]["left"], data["rig"]["right"]):
        for key in ("fx", "fy", "cx", "cy"):
            camera[key] /= 4
        for key in ("width", "height"):
            camera[key] //= 4
    data["sensor"]["pixel_um"] *= 4
    data["sensor"]["exposure_s"] /= 16
    return SceneSpec.model_validate(data)


def quick(scene: SceneSpec) -> dict[str, Any]:
    """Give a scene's data with few samples and a short experiment."""
    data = scene.model_dump(mode="json")
    data["render"] |= QUICK
    data["experiment"] = EXPERIMENT
    return data


def copy_scenes(source: Path, into: Path) -> None:
    """Copy a folder of scenes and sweeps, the scenes as regions."""
    for path in sorted(source.rglob("*.yaml")):
        copy = into / path.relative_to(source)
        copy.parent.mkdir(parents=True, exist_ok=True)
        if "rig" in yaml.safe_load(path.read_text(encoding="utf-8")):
            copy.write_text(dump_scene(region(load_scene(path))), encoding="utf-8")
        else:
            copy.write_bytes(path.read_bytes())
