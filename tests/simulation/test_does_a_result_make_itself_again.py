"""Does the scene that a simulation reports make the same pictures once more?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from regions import with_roi

from simtip.scene_file import load_scene
from simtip.simulation import Simulation, simulate

SCENES = Path(__file__).resolve().parents[2] / "scenes"
FOUND_ON_THE_WAY = ["04_flicker", "09_led_panel"]
"""White balance, and exposure under lamps that may ripple."""


def again(done: Simulation) -> Simulation:
    return simulate(done.spec.model_copy(update={"seed": done.light_seed}), seed=done.seed)


@pytest.mark.slow
@pytest.mark.parametrize("name", FOUND_ON_THE_WAY)
@pytest.mark.parametrize("auto", [{}, {"background_dn": 120.0}])
def test_what_was_found_on_the_way_is_found_again(name, auto):
    scene = load_scene(SCENES / f"{name}.yaml")
    scene = scene.model_copy(update={"sensor": scene.sensor.model_copy(update=auto)})
    small = with_roi(scene, [800, 850, 30, 40], [1010, 850, 30, 40], light_step_mm=4.0)
    first = simulate(small)
    second = again(first)
    assert second.spec == first.spec
    for a, b in zip(first.images, second.images, strict=True):
        np.testing.assert_array_equal(a, b)
