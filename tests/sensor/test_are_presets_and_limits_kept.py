"""Do presets mean what they say, overrides win, and impossible sensors get one clear line?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip import sensor
from simtip.errors import InputError
from simtip.presets import PRESETS
from simtip.scene_file import dump_scene, load_scene
from simtip.seeding import stream
from simtip.spec import SensorSpec

BASE = {"exposure_s": 0.05}


@pytest.fixture
def load(tmp_path, scene_path):
    """Load the paper's scene with another sensor."""

    def loaded(block):
        text = scene_path.read_text(encoding="utf-8")
        start, end = text.index("sensor:"), text.index("detect:")
        path = tmp_path / "scene.yaml"
        path.write_text(f"{text[:start]}sensor: {block}\n\n{text[end:]}", encoding="utf-8")
        return load_scene(path)

    return loaded


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_valid_and_the_scene_can_override_it(name, load):
    plain = load(f"{{preset: {name}, exposure_s: 0.05}}").sensor
    for key, value in PRESETS[name].items():
        if key != "effects":
            assert getattr(plain, key) == value
    # Strictly validated: a preset could not be written in a scene otherwise.
    spelled_out = {**PRESETS[name], **BASE}
    assert SensorSpec.model_validate(spelled_out).model_copy(update={"preset": name}) == plain
    changed = load(
        f"{{preset: {name}, exposure_s: 0.05, read_noise_e: 0, "
        "quantum_efficiency: [0.1, 0.2, 0.3], effects: {dsnu: false}}"
    ).sensor
    assert changed.read_noise_e == 0
    assert changed.quantum_efficiency == (0.1, 0.2, 0.3)
    assert changed.pixel_um == plain.pixel_um
    assert not changed.effects.dsnu
    assert changed.effects.full_well == plain.effects.full_well


def test_an_override_may_be_the_default_value(load):
    """10,000 e- is the field's default, but given is given."""
    block = "{preset: generic_3um2, exposure_s: 0.05, full_well_e: 10000}"
    assert load(block).sensor.full_well_e == 10000


def test_a_preset_survives_the_resolved_scene(load, tmp_path):
    spec = load("{preset: low_noise, exposure_s: 0.01, dsnu_e: 0.25}")
    path = tmp_path / "resolved.yaml"
    path.write_text(dump_scene(spec), encoding="utf-8")
    assert load_scene(path) == spec


def test_the_papers_scene_has_no_preset_and_no_new_effect(scene):
    expected = {"full_well_e": 10000, "read_noise_e": 5, "gain_dn_per_e": 0.0255, "bit_depth": 8}
    for key, value in expected.items():
        assert getattr(scene.sensor, key) == value
    assert scene.sensor.preset is None
    for key in ("prnu_percent", "dsnu_e", "dark_current_e_per_s", "hot_fraction", "dead_fraction"):
        assert getattr(scene.sensor, key) == 0
    assert sensor.fixed_pattern(scene.sensor, scene.rig.left, "left").response is None


def test_the_ideal_camera_only_rounds():
    spec = SensorSpec(preset="ideal", **BASE)
    light = np.random.default_rng(1).random((20, 30, 3)) * 0.04
    image = sensor.expose(light, spec, camera=sensor.UNIFORM, rng=stream(1))
    exact = sensor.mean_electrons(light, spec) * 0.0125
    np.testing.assert_array_equal(image, np.minimum(np.rint(exact), 255))
    assert 20 < exact.mean() < 255 < exact.max()


def test_the_ideal_camera_is_as_bright_as_the_generic_one():
    ideal, generic = (SensorSpec(preset=name, **BASE) for name in ("ideal", "generic_3um2"))
    for key in ("pixel_um", "wavelength_nm", "quantum_efficiency", "gain_dn_per_e", "bit_depth"):
        assert getattr(ideal, key) == getattr(generic, key)


def test_the_figures_follow_from_their_sources():
    """Decibels of the data sheets, worked out here once more."""
    generic, low = PRESETS["generic_3um2"], PRESETS["low_noise"]
    assert generic["full_well_e"] == pytest.approx(10 ** (43 / 10), rel=0.005)
    assert generic["read_noise_e"] == pytest.approx(10 ** (43 / 10) / 10 ** (61 / 20), rel=0.02)
    well = 10 ** (40.3 / 10)
    assert low["full_well_e"] == pytest.approx(well, rel=0.005)
    rounding = 1 / 12 / low["gain_dn_per_e"] ** 2
    threshold = np.sqrt(low["read_noise_e"] ** 2 + rounding + 0.25) + 0.5
    assert 20 * np.log10(well / threshold) == pytest.approx(71.3, abs=0.05)


@pytest.mark.parametrize("name", ["generic_3um2", "low_noise"])
def test_the_well_of_a_real_camera_fills_before_the_range_ends(name):
    spec = SensorSpec(preset=name, **BASE)
    full_dn = spec.gain_dn_per_e * spec.full_well_e + spec.black_level_dn
    assert 0.98 * 2**spec.bit_depth < full_dn + 1 <= 2**spec.bit_depth
    # Read noise in the dark does not reach 0 DN often enough to shift the mean.
    assert spec.black_level_dn > 4 * spec.gain_dn_per_e * np.hypot(spec.read_noise_e, spec.dsnu_e)


BAD = {
    "quantum_efficiency: [0.5, 1.01, 0.5]": ("quantum_efficiency[1]", "from 0 to 1, not 1.01"),
    "full_well_e: 0.5": ("full_well_e", "from 1 to 1e+09, not 0.5"),
    "bit_depth: 9.5": ("bit_depth", "8, 10, 12 or 16"),
    "bit_depth: 9": ("bit_depth", "8, 10, 12 or 16"),
    "read_noise_e: -1": ("read_noise_e", "from 0 to 1e+06, not -1"),
    "dsnu_e: -0.1": ("dsnu_e", "from 0 to 1e+06, not -0.1"),
    "prnu_percent: 21": ("prnu_percent", "from 0 to 20, not 21"),
    "dark_current_e_per_s: -1": ("dark_current_e_per_s", "from 0 to 1e+09, not -1"),
    "temperature_c: -274": ("temperature_c", "from -273.15 to 200, not -274"),
    "dark_doubling_k: 0": ("dark_doubling_k", "from 1 to 100, not 0"),
    "dead_fraction: 1": ("dead_fraction", "from 0 to 0.1, not 1"),
    "gain_dn_per_e: 0": ("gain_dn_per_e", "from 1e-06 to 1e+06, not 0"),
    "fixed_pattern_seed: -1": ("fixed_pattern_seed", "at least 0 and below 9.22337e+18, not -1"),
    "black_level_dn: 70000": ("black_level_dn", "give at least 0 and below"),
    "background_dn: 70000": ("background_dn", "give above"),
    "background_dn: -1": ("background_dn", "give above"),
    "preset: best": ("preset", "'ideal', 'generic_3um2' or 'low_noise', not the text 'best'"),
    "preset: [ideal]": ("preset", "'ideal', 'generic_3um2' or 'low_noise'"),
    "effects: {prnu: 1}": ("effects.prnu", "true or false"),
    "effects: {flare: true}": ("effects.flare", "unknown key"),
}


@pytest.mark.parametrize("line", BAD)
@pytest.mark.parametrize("preset", ["", "preset: low_noise, "])
def test_an_impossible_sensor_is_one_line_with_field_and_range(line, preset, load):
    if preset and "preset" in line:
        pytest.skip("two presets")
    field, said = BAD[line]
    with pytest.raises(InputError) as caught:
        load(f"{{{preset}exposure_s: 0.05, {line}}}")
    text = str(caught.value)
    assert caught.value.field == f"sensor.{field}"
    assert caught.value.remedy not in ("", "correct it")
    assert said in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("block", "field", "low", "high"),
    [
        ("", "black_level_dn", "at least 0", 255),
        ("preset: low_noise, ", "black_level_dn", "at least 0", 4095),
        ("", "background_dn", "above 0", 255),
        ("preset: generic_3um2, ", "background_dn", "above 4", 255),
        ("preset: low_noise, ", "background_dn", "above 60", 4095),
        # Gamma bends the black level too: 255 (4 / 255)^0.5.
        ("preset: generic_3um2, gamma: 0.5, ", "background_dn", "above 31.94", 255),
    ],
)
def test_a_gray_level_is_told_both_ends_of_its_range(block, field, low, high, load):
    with pytest.raises(InputError) as caught:
        load(f"{{{block}{field}: {high}}}")
    assert caught.value.field == f"sensor.{field}"
    assert caught.value.remedy == f"give {low} and below {high}"
    assert getattr(load(f"{{{block}{field}: {high - 1}}}").sensor, field) == high - 1


@pytest.mark.parametrize("level", [4.0, 0.0, -3.0])
def test_a_background_at_the_black_level_is_refused(level, load):
    with pytest.raises(InputError, match="background_dn"):
        load(f"{{preset: generic_3um2, background_dn: {level}}}")
    assert load("{preset: generic_3um2, background_dn: 4.5}").sensor.background_dn == 4.5
