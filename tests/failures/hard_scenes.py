"""The scenes of scenes/hard, rendered with few samples, once in a session."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from simtip.scene_file import load_scene
from simtip.simulation import Simulation, simulate

FOLDER = Path(__file__).resolve().parents[2] / "scenes" / "hard"
NAMES = [file.stem for file in sorted(FOLDER.glob("*.yaml"))]
SAMPLES = 64
"""Per pixel: what they leave of noise is below the sensor's on all but the darkest parts."""


@cache
def simulated(name: str) -> Simulation:
    scene = load_scene(FOLDER / f"{name}.yaml")
    render = scene.render.model_copy(update={"noise": None, "samples": SAMPLES})
    return simulate(scene.model_copy(update={"render": render}))
