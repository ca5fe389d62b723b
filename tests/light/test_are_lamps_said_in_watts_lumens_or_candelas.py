"""Do power, flux and luminance mean what they say, and contradict one another nowhere?"""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from simtip.mix import lamp_weights
from simtip.scene_file import load_scene
from simtip.spec import SensorSpec, TubeLamp
from simtip.spectra import luminous_efficacy
from simtip.spectra.table import columns

AREA_M2 = np.pi * 0.026 * 1.2


def tube(**fields):
    return TubeLamp.model_validate({"name": "t", "centre_mm": (0, -1000, 0), **fields})


def lumens_per_watt(name):
    """By CIE's sum in steps of 5 nm."""
    light, eye = columns("illuminants")[name], columns("observer")["y"]
    return 683.002 * (light @ eye) / light.sum()


def test_without_the_new_fields_a_lamp_is_what_it_was():
    """The formula of the release before, operation by operation."""
    lamp = tube(radiant_power_w=7.3, power=0.9, rgb=(1, 2, 0.5), length_mm=900, diameter_mm=16)
    area = np.pi * 16 * 900 * 1e-6
    share = np.array((1.0, 2.0, 0.5)) / sum((1.0, 2.0, 0.5))
    before = 7.3 * 0.9 * share / (np.pi * area)
    assert np.array_equal(lamp.radiance(), before)
    assert np.array_equal(lamp_weights(lamp, SensorSpec(), np.zeros(1)), before)


def test_lumens_become_watts_by_the_eye():
    """A T8 tube of 36 W gives 3350 lm: some 10 W of light."""
    lamp = tube(luminous_flux_lm=3350, spectrum="FL11")
    assert lamp.rated_power_w() == pytest.approx(3350 / lumens_per_watt("FL11"), rel=3e-3)
    assert 9 < lamp.rated_power_w() < 11
    watts = tube(radiant_power_w=lamp.rated_power_w(), spectrum="FL11")
    assert lamp.total_radiance() == watts.total_radiance()


def test_luminance_is_the_radiance_as_the_eye_weighs_it():
    lamp = tube(luminance_cd_m2=11000, spectrum="FL2", power=0.5)
    assert lamp.total_radiance() * luminous_efficacy("FL2") == pytest.approx(5500, rel=1e-12)
    assert lamp.rated_power_w() == pytest.approx(
        np.pi * AREA_M2 * 11000 / luminous_efficacy("FL2"), rel=1e-12
    )


def test_a_lamp_survives_being_written_and_read():
    for lamp in (tube(luminance_cd_m2=9000, spectrum="FL2"), tube(), tube(spectrum="FL3.12")):
        for part in ({}, {"exclude_unset": True}):
            again = TubeLamp.model_validate_json(lamp.model_dump_json(**part))
            assert again.total_radiance() == lamp.total_radiance()


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"luminance_cd_m2": 9000}, "needs a spectrum"),
        ({"luminous_flux_lm": 3000}, "needs a spectrum"),
        ({"luminance_cd_m2": 9000, "luminous_flux_lm": 3000, "spectrum": "FL2"}, "one of them"),
        ({"luminance_cd_m2": 9000, "radiant_power_w": 9, "spectrum": "FL2"}, "one of them"),
        ({"radiant_power_w": None}, "without power"),
        ({"spectrum": "FL2", "rgb": (1, 0.9, 0.8)}, "one of them"),
        ({"spectrum": "FL13"}, "FL12"),
        ({"luminance_cd_m2": -1, "spectrum": "FL2"}, "greater"),
    ],
)
def test_contradictions_are_refused(fields, says):
    with pytest.raises(ValidationError, match=says):
        tube(**fields)


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"quantum_efficiency": (0.5, 0.96, 0.5)}, "green channel .* over 1"),
        ({"wavelength_nm": (600, 540, 395)}, "blue channel .* blind"),
    ],
)
def test_a_response_beyond_the_possible_is_refused(fields, says):
    SensorSpec(spectral_response="nikon_d5100")
    with pytest.raises(ValidationError, match=says):
        SensorSpec.model_validate({"spectral_response": "nikon_d5100", **fields})


def test_a_scene_file_can_say_all_of_it(tmp_path, scene_path):
    text = scene_path.read_text(encoding="utf-8")
    text = text.replace(
        "direction: [1, 0, 0]}",
        "direction: [1, 0, 0], spectrum: FL2, luminance_cd_m2: 9000,\n"
        "     ballast: {kind: magnetic, mains_hz: 60, waveform: harmonics,\n"
        "               harmonics: [[1, 0], [0.2, 30]]}}",
        1,
    ).replace("sensor:\n", "sensor:\n  spectral_response: nikon_d5100\n  row_time_s: 1.5e-5\n")
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    spec = load_scene(path)
    assert spec.lamps[0].spectrum == "FL2"
    assert spec.lamps[0].ballast.harmonics == ((1, 0), (0.2, 30))
    assert spec.sensor.row_time_s == 1.5e-5
