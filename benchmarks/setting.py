"""The scene that the benchmarks run on: the paper's set-up, or a small part of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from simtip import SceneSpec, load_scene

SCENE = Path(__file__).resolve().parents[1] / "scenes" / "01_single_tip.yaml"
QUICK_PX = (200, 420)
"""Width and height of the part that a smoke run reads out; the needle's tip is well inside."""
QUICK_SAMPLES = 16


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


def with_samples(scene: SceneSpec, samples: int) -> SceneSpec:
    """Give the scene with another number of samples per pixel."""
    render = scene.render.model_copy(update={"samples": samples})
    return scene.model_copy(update={"render": render})
