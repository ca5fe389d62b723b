"""Does every scene that ships load, and render small?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from regions import with_roi

from simtip.scene_file import load_scene
from simtip.simulation import simulate
from simtip.truth import scene_truth

SCENES = sorted((Path(__file__).resolve().parents[2] / "scenes").glob("*.yaml"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_it_loads_and_renders_its_tip(path):
    scene = load_scene(path)
    truth = scene_truth(scene)
    corners = [np.rint(view.tip_px - [30, 40]).astype(int) for view in (truth.left, truth.right)]
    small = with_roi(
        scene, *([int(u), int(v), 60, 60] for u, v in corners), samples=16, light_step_mm=1.0
    )
    done = simulate(small)
    for image, view in zip(done.images, (done.truth.left, done.truth.right), strict=True):
        gray = image.astype(float).mean(axis=2)
        u, v = np.rint(view.tip_px).astype(int)
        # The needle stands above the tip, the bright board lies below it.
        assert gray[v - 25, u] < 0.6 * gray[v + 10, u]
