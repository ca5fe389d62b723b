"""Do radiance, photons, electrons and DN follow the formulas, and is the noise-free image exact?"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import constants

from simtip import sensor
from simtip.optics import irradiance
from simtip.seeding import stream
from simtip.spec import SensorSpec

PAPER = {"exposure_s": 0.04}


def flat(value, shape=(4, 5)):
    return np.full((*shape, 3), value, dtype=np.float32)


def take(light, spec, rng):
    return sensor.expose(light, spec, camera=sensor.UNIFORM, rng=rng)


def test_electrons_of_the_papers_camera_by_hand():
    """L = 0.01 W m^-2 sr^-1 of 540 nm for 40 ms on 3.2 um at f/1.4, half of the photons counted.

    E = pi 0.01 / (4 x 1.96) = 4.0072e-3 W/m^2; on 1.024e-11 m^2 for 0.04 s: 1.6413e-15 J; a photon
    has h c / 540 nm = 3.6786e-19 J: 4461.8 photons, 2230.9 electrons.
    """
    mean = sensor.mean_electrons(irradiance(flat(0.01), 1.4), SensorSpec(**PAPER))
    np.testing.assert_allclose(mean[..., 1], 2230.9, rtol=2e-5)
    np.testing.assert_allclose(mean[..., 0] / mean[..., 1], 600 / 540, rtol=1e-12)
    np.testing.assert_allclose(mean[..., 2] / mean[..., 1], 460 / 540, rtol=1e-12)


def test_each_channel_has_its_own_efficiency():
    spec = SensorSpec(**PAPER, quantum_efficiency=(0.5, 0.25, 0.1), wavelength_nm=(500,) * 3)
    np.testing.assert_allclose(
        sensor.responsivity(spec) / sensor.responsivity(spec)[0], [1, 0.5, 0.2], rtol=1e-14
    )


@pytest.mark.parametrize(
    ("change", "factor"),
    [({"exposure_s": 0.08}, 2), ({"pixel_um": 6.4}, 4)],
)
def test_light_scales_with_time_and_area(change, factor):
    before = sensor.responsivity(SensorSpec(**PAPER))
    after = sensor.responsivity(SensorSpec(**{**PAPER, **change}))
    np.testing.assert_allclose(after / before, factor, rtol=1e-14)


def test_the_steps_make_the_chain():
    """Oracle: the formulas once more, from scipy's constants."""
    spec = SensorSpec(**PAPER)
    E = np.pi * 0.02 / (4 * 1.4**2)
    mu_p = (3.2e-6) ** 2 * E * 0.04 * np.array([600, 540, 460]) * 1e-9 / (constants.h * constants.c)
    np.testing.assert_allclose(irradiance(np.array(0.02), 1.4), E, rtol=1e-15)
    np.testing.assert_allclose(
        sensor.photons(np.array([E] * 3), 3.2, 0.04, (600, 540, 460)), mu_p, rtol=1e-9
    )
    np.testing.assert_allclose(E * sensor.responsivity(spec), 0.5 * mu_p, rtol=1e-9)


def test_without_noise_the_image_is_the_expected_value_rounded():
    """Oracle: rounding in double precision, halves to even, over every level and beyond."""
    spec = SensorSpec(**PAPER, noise=False, black_level_dn=2.25)
    light = np.linspace(0, 0.04, 200 * 97 * 3, dtype=np.float32).reshape(200, 97, 3)
    mean = light.astype(np.float64) * sensor.responsivity(spec)
    expected = np.minimum(mean, 10000) * 0.0255 + 2.25
    assert (expected > 255).any()
    np.testing.assert_allclose(
        sensor.expected_dn(light, spec, camera=sensor.UNIFORM),
        np.minimum(expected, 255),
        rtol=1e-14,
    )
    image = take(light, spec, stream(1))
    assert image.dtype == np.uint8
    np.testing.assert_array_equal(image, np.clip(np.round(expected), 0, 255))


def test_halves_are_rounded_to_even():
    dn = np.array([-0.6, 0.5, 1.5, 2.5, 254.5, 254.6, 255.5, 1e9])
    np.testing.assert_array_equal(sensor.quantise(dn, 8), [0, 0, 2, 2, 254, 255, 255, 255])
    np.testing.assert_array_equal(sensor.quantise(dn, 12)[-2:], [256, 4095])
    assert sensor.quantise(dn, 12).dtype == np.uint16


def test_darkness_is_the_black_level():
    spec = SensorSpec(**PAPER, read_noise_e=0, black_level_dn=7)
    assert (take(flat(0), spec, stream(1)) == 7).all()


@pytest.mark.parametrize("light", [1.0, 1e30, 3e38])
@pytest.mark.parametrize("noise", [True, False])
def test_a_full_well_is_full_and_never_more(light, noise):
    spec = SensorSpec(**PAPER, read_noise_e=0, noise=noise, gain_dn_per_e=0.02)
    assert (take(flat(light), spec, stream(1)) == 200).all()


def test_the_full_well_cuts_the_shot_noise_but_not_the_read_noise():
    spec = SensorSpec(**PAPER, read_noise_e=100, gain_dn_per_e=0.02)
    image = take(flat(1.0, (100, 100)), spec, stream(1)).astype(float)
    assert image.mean() == pytest.approx(200, abs=0.06)
    assert image.std() == pytest.approx(np.sqrt(2**2 + 1 / 12), rel=0.02)


def test_the_range_ends_at_255():
    spec = SensorSpec(**PAPER, gain_dn_per_e=0.1)
    assert (take(flat(1.0), spec, stream(1)) == 255).all()


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (np.zeros((4, 5)), "shape"),
        (np.zeros((4, 5, 4)), "shape"),
        (np.zeros((0, 5, 3)), "shape"),
        (np.zeros((4, 5, 3), dtype=complex), "real"),
        (flat(-1e-9), "negative"),
        (flat(np.nan), "not finite"),
        (flat(np.inf), "not finite"),
    ],
)
def test_what_is_no_irradiance_is_refused(light, message):
    for use in (
        lambda: take(light, SensorSpec(**PAPER), stream(1)),
        lambda: sensor.mean_electrons(light, SensorSpec(**PAPER)),
        lambda: sensor.expected_dn(light, SensorSpec(**PAPER), camera=sensor.UNIFORM),
    ):
        with pytest.raises(ValueError, match=message):
            use()


def test_one_bad_pixel_is_found():
    light = flat(0.01)
    light[2, 3, 1] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        take(light, SensorSpec(**PAPER), stream(1))
