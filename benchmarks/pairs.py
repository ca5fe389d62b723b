"""Pairs of tips for the benchmarks of matching and triangulation."""

from __future__ import annotations

import numpy as np
from setting import paper_scene

from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.seeding import stream

STROKES_MM = (28.0, 22.0, 15.0)
"""Of the paper's robot: the tips fill this box around the scene's own."""
SIGMA_PX = 0.3


def tip_pairs(count: int) -> tuple[StereoRig, Array, Array, Array]:
    """Give the paper's rig, true tips (count, 3) mm, and noisy left and right pixels (count, 2)."""
    scene = paper_scene(quick=False)
    rig = scene.rig.rig()
    rng = stream(1, "benchmark", "pairs")
    points = np.array(scene.needle.tip_mm) + rng.uniform(-0.5, 0.5, (count, 3)) * STROKES_MM
    left, right = (pixels + rng.normal(0, SIGMA_PX, pixels.shape) for pixels in rig.project(points))
    return rig, points, left, right
