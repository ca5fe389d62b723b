"""Does every scene that ships still give the light that is stored of it, but for chance?"""

from __future__ import annotations

import numpy as np
import pytest
from stored_crops import (
    MAKE,
    SCENES,
    coverage,
    faults,
    file_of,
    identity,
    leave_pictures,
    load,
    mixed,
    quick_or_slow,
)

from simtip.spec import SceneSpec


@pytest.mark.parametrize(
    "path", [quick_or_slow(path) for path in SCENES], ids=lambda path: path.stem
)
def test_its_crops_differ_from_the_stored_ones_by_noise_alone(path, simulated, tmp_path):
    done = simulated(path)
    again = f"{MAKE} {path.stem}"
    assert file_of(path).exists(), f"no reference is stored: {again}"
    reference = load(file_of(path))
    assert identity(done.spec) == reference.scene, f"the scene was changed since: {again}"
    light = mixed(done.spec, done.views)
    found = faults(reference, light, coverage(done.views))
    if found:
        leave_pictures(reference, light, coverage(done.views), tmp_path / path.stem)
    assert not found, f"{'; '.join(found)}; pictures in {tmp_path / path.stem}"


def test_no_reference_is_left_of_a_scene_that_is_gone():
    stored = {file.stem for file in file_of(SCENES[0]).parent.glob("*.npz")}
    assert stored <= {path.stem for path in SCENES}


def shifted(light: np.ndarray) -> np.ndarray:
    """By a tenth of a pixel to the right."""
    return 0.9 * light + 0.1 * np.roll(light, 1, axis=2)


def dimmer(light: np.ndarray) -> np.ndarray:
    return 0.995 * light


def one_pixel_off(light: np.ndarray) -> np.ndarray:
    """A speck of 2 % on the board."""
    changed = light.copy()
    changed[1, 5, 40] *= 1.02
    return changed


@pytest.mark.parametrize("fault", [shifted, dimmer, one_pixel_off], ids=lambda f: f.__name__)
def test_a_fault_is_seen_and_leaves_pictures(fault, simulated, tmp_path):
    path = SCENES[0]
    done, reference = simulated(path), load(file_of(path))
    light = fault(mixed(done.spec, done.views))
    assert faults(reference, light, coverage(done.views))
    leave_pictures(reference, light, coverage(done.views), tmp_path)
    names = {"rendered", "reference", "z"}
    assert {file.name for file in tmp_path.iterdir()} == {
        f"{side}_{name}.png" for side in ("left", "right") for name in names
    }


def test_a_changed_scene_is_told_from_a_fault(simulated):
    spec = simulated(SCENES[0]).spec
    data = spec.model_dump(mode="json")
    data["detect"]["threshold"] = 90
    assert identity(SceneSpec.model_validate(data)) == identity(spec)
    data["lamps"][0]["centre_mm"][0] += 1
    assert identity(SceneSpec.model_validate(data)) != identity(spec)
