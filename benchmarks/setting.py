"""The scenes that the benchmarks run on: the paper's set-up, or a small part of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from simtip import SceneSpec, load_scene

SCENE = Path(__file__).resolve().parents[1] / "scenes" / "01_single_tip.yaml"
QUICK_PX = (200, 420)
"""Width and height of the part that a smoke run reads out; the needle's tip is well inside."""
QUICK_SAMPLES = 64
SMALLEST_ROI = (0, 0, 8, 8)
"""What is read out of a camera that does not count."""


def paper_scene(*, quick: bool) -> SceneSpec:
    """Give the paper's scene, or for a smoke run the same read out around the tip only."""
    scene = load_scene(SCENE)
    if not quick:
        return scene
    data = scene.model_dump(mode="json")
    width, height = QUICK_PX
    tips = scene.rig.rig().project(np.array(scene.needle.tip_mm))
    for side, (u, v) in zip(("left", "right"), tips, strict=True):
        corner = [round(u) - width // 2, round(v) - height + 40]
        data["rig"][side]["roi"] = [*corner, width, height]
    data["render"]["samples"] = QUICK_SAMPLES
    return SceneSpec.model_validate(data)


def with_render(scene: SceneSpec, **fields: object) -> SceneSpec:
    """Give the scene with other render settings."""
    render = scene.render.model_copy(update=fields)
    return scene.model_copy(update={"render": render})


def with_samples(scene: SceneSpec, samples: int) -> SceneSpec:
    """Give the scene with a fixed number of samples per pixel, whatever noise that leaves."""
    return with_render(scene, samples=samples, noise=None)


def left_only(scene: SceneSpec) -> SceneSpec:
    """Give the scene with next to nothing read out of the right camera."""
    data = scene.model_dump(mode="json")
    data["rig"]["right"]["roi"] = list(SMALLEST_ROI)
    return SceneSpec.model_validate(data)


def four_lamps(scene: SceneSpec, *, rolling: bool) -> SceneSpec:
    """Give the scene with four lamps; rolling: they flicker before a rolling shutter."""
    data = scene.model_dump(mode="json")
    tubes = [
        _tube(data["lamps"][0], k, [x, -1500.0, z], ripple=0.3 if rolling else 0.0)
        for k, (x, z) in enumerate([(-900.0, -600.0), (900.0, -600.0), (-900, -1800), (900, -1800)])
    ]
    data["lamps"] = tubes
    if rolling:
        data["sensor"] |= {"exposure_s": 0.004, "row_time_s": 2e-5}
    return SceneSpec.model_validate(data)


def _tube(
    like: dict[str, Any], number: int, centre_mm: list[float], ripple: float
) -> dict[str, Any]:
    ballast = {"kind": "magnetic", "ripple": ripple, "phase_deg": 60.0 * number}
    name = {"name": f"lamp{number}", "centre_mm": centre_mm}
    return {**like, **name, **({"ballast": ballast} if ripple else {})}
