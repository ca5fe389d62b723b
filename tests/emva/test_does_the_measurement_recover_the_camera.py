import json
from dataclasses import dataclass

import numpy as np
import pytest
from invented_camera import CAMERAS, BenchCamera, middling_10_bit, noisy_8_bit, quiet_12_bit

from simtip.emva import measure_camera, plan_measurement
from simtip.emva.result import KEYS


def measured(camera, **wishes):
    plan = plan_measurement(camera, bit_depth=camera.bit_depth, exposure_s=0.01, **wishes)
    return measure_camera(camera, plan)


def truth_of(camera):
    return {
        "K_dn_per_e": camera.K,
        "sigma_d_e": camera.sigma_d_e,
        "dark_current_e_per_s": camera.dark_e_per_s,
        "full_well_e": camera.full_well_e,
        "prnu_percent": camera.prnu_percent,
        "dsnu_e": camera.dsnu_e,
        "snr_max": camera.full_well_e**0.5,
        "quantum_efficiency": camera.eta,
        "dark_current_by_variance_e_per_s": camera.dark_e_per_s,
    }


def within(estimate, truth):
    """2 % or the 99 % interval, whichever is larger."""
    return abs(estimate.value - truth) <= max(0.02 * truth, estimate.high - estimate.value)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n != "12 bit")) for n in CAMERAS]
)
def test_every_parameter_comes_back(name):
    camera = CAMERAS[name](shape=(96, 96))
    found = measured(camera)
    for key, truth in truth_of(camera).items():
        assert within(getattr(found, key), truth), key
    assert found.full_well_limit == "well"
    # An interval as wide as the value itself would pass the line above.
    for key, share in (("K_dn_per_e", 0.01), ("sigma_d_e", 0.15), ("prnu_percent", 0.05)):
        estimate = getattr(found, key)
        assert estimate.high - estimate.value < share * estimate.value, key
    assert sum(found.in_fit) > 30


@pytest.mark.slow
def test_a_quiet_8_bit_camera_is_said_to_be_extrapolated():
    found = measured(noisy_8_bit())
    assert any("0.24 DN^2" in note for note in found.notes)
    assert any("pixel by pixel" in note for note in found.notes)
    assert not measured(middling_10_bit()).notes


@pytest.mark.slow
@pytest.mark.parametrize("black_dn", [0.0, 0.7])
def test_a_dark_level_cut_off_at_zero_is_said_and_does_not_bias(black_dn):
    camera = middling_10_bit(black_dn=black_dn, shape=(96, 96))
    found = measured(camera)
    assert any("at DN 0" in note for note in found.notes)
    for key in ("K_dn_per_e", "sigma_d_e", "dsnu_e", "prnu_percent", "dark_current_e_per_s"):
        assert within(getattr(found, key), truth_of(camera)[key]), key


def black_at_zero(**change):
    own = {"K": 0.2, "sigma_d_e": 5.0, "full_well_e": 18000, "bit_depth": 12, "black_dn": 0.0}
    return BenchCamera(**{**own, "shape": (128, 128), **change})


@pytest.mark.slow
@pytest.mark.parametrize(
    "change", [{}, {"K": 1.0, "sigma_d_e": 20.0, "bit_depth": 16, "dsnu_e": 5.0}]
)
def test_a_noisy_camera_without_a_black_level_has_its_pattern_measured(change):
    """Dark and weakly lit frames are cut off at DN 0 until the light lifts K sigma_d off it."""
    camera = black_at_zero(**change)
    found = measured(camera)
    for key, truth in truth_of(camera).items():
        assert within(getattr(found, key), truth), key
    for key in ("dsnu_e", "prnu_percent"):
        estimate = getattr(found, key)
        assert estimate.high - estimate.value < 0.1 * estimate.value, key


def test_the_weak_light_stays_where_the_dark_is_not_cut_off():
    plan = plan_measurement(middling_10_bit(), bit_depth=10, exposure_s=0.01)
    camera = middling_10_bit()
    # 0.4 DN^2 over K^2 electrons, at the quantum efficiency; probed on 64 x 64 pixels.
    assert plan.flat_photons[1] == pytest.approx(0.4 / camera.K**2 / camera.eta, rel=0.2)


@dataclass
class NoShotNoise(BenchCamera):
    """As many electrons as on average, always."""

    def __call__(self, photons, exposure_s, count):
        mean = self.eta * photons * self.response + self.dark_e_per_s * exposure_s
        for _ in range(count):
            electrons = np.minimum(mean, self.full_well_e) + self.offset_e
            electrons = electrons + self.rng.standard_normal(self.shape) * self.sigma_d_e
            dn = np.clip(np.rint(self.black_dn + self.K * electrons), 0, 2**self.bit_depth - 1)
            yield dn.astype(np.uint16)


@pytest.mark.slow
@pytest.mark.parametrize("noise_seed", range(6))
@pytest.mark.parametrize("sigma_d_e", [2.0, 8.0])
def test_a_camera_without_shot_noise_has_no_gain_to_find(noise_seed, sigma_d_e):
    found = measured(
        NoShotNoise(
            K=0.2, sigma_d_e=sigma_d_e, full_well_e=18000, bit_depth=12, black_dn=32.0,
            noise_seed=noise_seed,
        )
    ).to_dict()  # fmt: skip
    for key in KEYS:
        assert found[key] is None
        assert found["ci99"][key] is None
        assert "noise" in found["reasons"][key]


@pytest.mark.slow
def test_an_adc_that_clips_first_is_said_and_measured():
    camera = quiet_12_bit(full_well_e=50_000, shape=(96, 96))
    found = measured(camera)
    assert found.full_well_limit == "adc"
    assert within(found.full_well_e, (4095 - camera.black_dn) / camera.K)
    assert any("the well holds more" in note for note in found.notes)


@pytest.mark.slow
def test_a_well_within_read_noise_of_the_top_code_is_said():
    camera = middling_10_bit(full_well_e=(1023 - 16) / 0.08 - 12)
    assert any("reaches the top code" in note for note in measured(camera).notes)


@pytest.mark.slow
def test_relative_photon_numbers_change_nothing_but_the_quantum_efficiency():
    found = measured(quiet_12_bit(eta=0.6e-3), photons_absolute=False)
    assert found.quantum_efficiency.value is None
    assert within(found.K_dn_per_e, 0.2)


def test_the_result_is_plain_json():
    data = json.loads(json.dumps(measured(quiet_12_bit(shape=(32, 32))).to_dict()))
    assert set(KEYS) <= set(data)
    assert set(data["ci99"]) == set(KEYS)
    for key in KEYS:
        low, high = data["ci99"][key]
        assert low <= data[key] <= high
