"""Is a re-mixed pair the pair that rendering with other lamps would have given?"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.errors import InputError
from simtip.light_file import Lights, lights_name, write_lights
from simtip.light_inputs import first_difference, light_digest
from simtip.remix import remix
from simtip.simulation import simulate
from simtip.spec import SceneSpec

CHANGES = {
    "dimmed": {"lamps.0.power": 0.4},
    "coloured": {"lamps.1.rgb": [2.0, 1.0, 0.5]},
    "a spectrum": {"lamps.0.spectrum": "FL11"},
    "ripple before a rolling shutter": {
        "lamps.0.ballast.kind": "magnetic",
        "lamps.0.ballast.ripple": 0.6,
        "sensor.row_time_s": 1e-4,
        "sensor.exposure_s": 0.004,
    },
    "longer": {"sensor.exposure_s": 0.08},
    "auto-exposed": {"sensor.background_dn": 150.0},
    "another sensor": {"sensor.read_noise_e": 20.0, "sensor.gain_dn_per_e": 0.02},
    "darker room": {"ambient.radiance_w_m2_sr": [0.001, 0.001, 0.001]},
    "a blurring lens": {"rig.left.lens.aberration_um": 3.0},
}


def changed(spec: SceneSpec, changes: dict[str, object]) -> SceneSpec:
    data = spec.model_dump(mode="json")
    for path, value in changes.items():
        *parts, last = path.split(".")
        place = data
        for part in parts:
            place = place[int(part)] if part.isdigit() else place[part]
        place[last] = value
    return SceneSpec.model_validate(data)


@pytest.fixture(scope="module")
def small(scene) -> SceneSpec:
    return with_roi(
        scene, [800, 850, 40, 50], [1010, 850, 30, 40], noise=None, samples=16, light_step_mm=2.0
    )


@pytest.fixture(scope="module")
def folder(small, tmp_path_factory):
    made = tmp_path_factory.mktemp("lights")
    done = simulate(small, seed=5)
    for side, view in zip(("left", "right"), done.views, strict=True):
        write_lights(made / lights_name(side), Lights(view, done.spec, done.seed, side))
    return made


@pytest.mark.slow
@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_a_remixed_pair_is_the_rendered_one_bit_for_bit(small, folder, changes):
    wanted = changed(small, changes)
    rendered, mixed = simulate(wanted, seed=5), remix(folder, wanted)
    assert mixed.spec == rendered.spec
    for a, b in zip(mixed.images, rendered.images, strict=True):
        np.testing.assert_array_equal(a, b)


def test_without_a_scene_the_same_pair_comes_out(small, folder):
    for a, b in zip(remix(folder).images, simulate(small, seed=5).images, strict=True):
        np.testing.assert_array_equal(a, b)


def test_another_seed_gives_the_sensors_other_noise_only(small, folder):
    one, other = remix(folder, small), remix(folder, small, seed=6)
    assert (one.images[0] != other.images[0]).any()
    np.testing.assert_array_equal(one.views[0].response, other.views[0].response)


GEOMETRY = {
    "needle.roll_deg": 5.0,
    "needle.material.roughness": 0.3,
    "lamps.0.length_mm": 1000.0,
    "lamps.1.centre_mm": [0, -1500, -1799],
    "background.albedo": [0.7, 0.8, 0.8],
    "rig.right.fx": 1900.0,
    "rig.left.lens.focus_mm": 178.0,
    "sensor.wavelength_nm": [610.0, 540.0, 460.0],
    "clutter.level": "light",
    "render.samples": 32,
}


@pytest.mark.parametrize("path", GEOMETRY)
def test_what_was_rendered_cannot_change(small, folder, path):
    wanted = changed(small, {path: GEOMETRY[path]})
    assert light_digest(wanted) != light_digest(small)
    field = path.replace(".0", "[0]").replace(".1", "[1]")
    assert (first_difference(small, wanted) or "").startswith(field)
    with pytest.raises(InputError, match="depends on it") as caught:
        remix(folder, wanted)
    assert caught.value.field.startswith(field)


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_what_is_mixed_later_leaves_the_light_as_it_was(small, changes):
    assert light_digest(changed(small, changes)) == light_digest(small)


def test_two_halves_of_different_scenes_are_refused(small, folder, tmp_path):
    for side in ("left", "right"):
        name = lights_name(side)
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    done = simulate(small, seed=6)
    write_lights(tmp_path / lights_name("right"), Lights(done.views[1], done.spec, 6, "right"))
    with pytest.raises(InputError, match="another scene or seed"):
        remix(tmp_path, small)
    (tmp_path / lights_name("right")).write_bytes((folder / lights_name("left")).read_bytes())
    with pytest.raises(InputError, match="swapped"):
        remix(tmp_path, small)
