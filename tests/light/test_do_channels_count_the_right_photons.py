"""Does the sensor, with one wavelength a channel, count the electrons of the whole spectrum?

The oracle adds up the lamp's light in steps of 0.01 nm, each with its own photon energy and quantum
efficiency. It shares the tables with simtip and nothing else.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simtip.mix import lamp_weights
from simtip.optics import irradiance
from simtip.sensor import mean_electrons
from simtip.spec import SensorSpec, TubeLamp
from simtip.spectra import (
    METALS,
    at_wavelengths,
    bands,
    channel_weights,
    effective_index,
    effective_reflectance,
    effective_wavelength,
    lamp_dependence,
    normal_reflectance,
    response,
    sensor_response,
    spectrum,
    tabulated,
)
from simtip.spectra.table import columns

H, C = 6.62607015e-34, 299792458.0
STEP = 0.01
NM = np.arange(380 + STEP / 2, 780, STEP)
WAVELENGTHS = (600.0, 540.0, 460.0)
FLUORESCENT = [f"FL{k}" for k in range(1, 13)]


def column(table, name):
    data = columns(table)
    return np.interp(NM, data["wavelength_nm"], data[name])


def one_watt(name):
    light = np.ones_like(NM) if name == "E" else column("illuminants", name)
    return light / (light.sum() * STEP)


def efficiency(sensor):
    """Absolute quantum efficiency (n, 3) of every step, as the documentation states it."""
    if sensor.spectral_response is None:
        nearest = np.abs(NM[:, None] - np.array(sensor.wavelength_nm)).argmin(axis=1)
        shape = np.eye(3)[nearest]
        own = np.ones(3)
    else:
        shape = np.stack([column(f"response_{sensor.spectral_response}", c) for c in "rgb"], -1)
        table = columns(f"response_{sensor.spectral_response}")
        own = np.array(
            [
                np.interp(nm, table["wavelength_nm"], table[c])
                for c, nm in zip("rgb", sensor.wavelength_nm, strict=True)
            ]
        )
    return shape / own * np.array(sensor.quantum_efficiency)


def electrons_by_the_nanometre(lamp, sensor, f_number):
    """Radiance to electrons for each step of the spectrum on its own."""
    area_m2 = np.pi * lamp.diameter_mm * lamp.length_mm * 1e-6
    radiance = lamp.radiant_power_w * lamp.power / (np.pi * area_m2) * one_watt(lamp.spectrum)
    on_sensor = np.pi * radiance / (4 * f_number**2)
    joules = on_sensor * (sensor.pixel_um * 1e-6) ** 2 * sensor.exposure_s
    photons = joules / (H * C / (NM * 1e-9))
    return (photons[:, None] * efficiency(sensor)).sum(axis=0) * STEP


@pytest.mark.parametrize("curve", [None, "nikon_d5100"])
@pytest.mark.parametrize("name", ["FL2", "FL7", "FL11", "FL3.15", "LED-B3", "A", "E"])
def test_the_chain_gives_the_electrons_of_the_whole_spectrum(name, curve):
    lamp = TubeLamp(name="t", centre_mm=(0, 0, 0), spectrum=name, power=0.7)
    sensor = SensorSpec(
        spectral_response=curve, quantum_efficiency=(0.45, 0.5, 0.59), wavelength_nm=(595, 535, 465)
    )
    light = lamp_weights(lamp, sensor, np.zeros(1)).reshape(1, 1, 3)
    found = mean_electrons(irradiance(light, 1.4), sensor)[0, 0]
    # The oracle's steps straddle the bands' edges: 1e-5.
    assert found == pytest.approx(electrons_by_the_nanometre(lamp, sensor, 1.4), rel=2e-5)


@pytest.mark.parametrize("name", ["FL2", "FL12", "D65"])
@settings(derandomize=True, deadline=None, max_examples=30)
@given(
    wavelengths=st.tuples(*[st.floats(400, 700)] * 3).filter(
        lambda w: min(abs(w[0] - w[1]), abs(w[1] - w[2]), abs(w[0] - w[2])) > 1
    )
)
def test_ideal_bands_count_every_photon_once(name, wavelengths):
    weights = channel_weights(spectrum(name), bands(wavelengths), wavelengths)
    counted = (weights * wavelengths).sum() * 1e-9 / (H * C)
    photons = (one_watt(name) * NM).sum() * STEP * 1e-9 / (H * C)
    assert counted == pytest.approx(photons, rel=1e-6)


def test_channels_of_one_wavelength_see_the_same_light():
    weights = channel_weights(spectrum("FL2"), bands((550, 550, 550)), (550, 550, 550))
    assert weights[0] == weights[1] == weights[2]
    assert weights[0] * 550 == pytest.approx((one_watt("FL2") * NM).sum() * STEP, rel=1e-6)


def test_the_power_of_a_lamp_without_infrared_is_kept():
    """Photon numbers are exact; a fluorescent lamp's power is then kept to 3 %."""
    for name in FLUORESCENT:
        total = channel_weights(spectrum(name), bands(WAVELENGTHS), WAVELENGTHS).sum()
        assert total == pytest.approx(1, abs=0.031), name


@settings(derandomize=True, deadline=None, max_examples=20)
@given(nm=st.floats(420, 680))
def test_a_narrow_line_counts_by_its_own_efficiency(nm):
    """A laser at any wavelength: weight times lambda_c is lambda r(lambda) / r(lambda_c)."""
    line = tabulated(np.array([nm - 0.01, nm, nm + 0.01]), np.array([0, 100, 0.0]))
    relative = response("nikon_d5100")
    found = channel_weights(line, relative, WAVELENGTHS)
    own = np.array([relative.at(np.array([w]))[0, k] for k, w in enumerate(WAVELENGTHS)])
    expected = nm * relative.at(np.array([nm]))[0] / (np.array(WAVELENGTHS) * own)
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-6)


def test_quantum_efficiency_scales_electrons_and_not_the_weights():
    lamp = TubeLamp(name="t", centre_mm=(0, 0, 0), spectrum="FL2")
    half, full = (
        SensorSpec(spectral_response="nikon_d5100", quantum_efficiency=(eta,) * 3)
        for eta in (0.3, 0.6)
    )
    assert np.array_equal(*(lamp_weights(lamp, s, np.zeros(1)) for s in (half, full)))


def test_effective_wavelength_is_the_photons_mean():
    for name in ("FL2", "E"):
        photons = (
            one_watt(name)[:, None]
            * NM[:, None]
            * efficiency(SensorSpec(spectral_response="nikon_d5100"))
        )
        expected = (photons * NM[:, None]).sum(axis=0) / photons.sum(axis=0)
        found = effective_wavelength(spectrum(name), response("nikon_d5100"))
        assert found == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("metal", METALS)
@pytest.mark.parametrize("curve", [None, "nikon_d5100"])
def test_a_metals_effective_reflectance_is_the_share_of_photons(metal, curve):
    sensor = SensorSpec(spectral_response=curve, wavelength_nm=WAVELENGTHS)
    relative = sensor_response(curve, WAVELENGTHS)
    reflectance = normal_reflectance(*at_wavelengths(METALS[metal], NM))
    for name in ("FL4", "E"):
        photons = one_watt(name)[:, None] * NM[:, None] * efficiency(sensor)
        expected = (photons * reflectance[:, None]).sum(axis=0) / photons.sum(axis=0)
        found = effective_reflectance(metal, spectrum(name), relative)
        assert found == pytest.approx(expected, rel=2e-5)
    # One n and k a channel reflect like the mean of the reflectance.
    index = effective_index(metal, spectrum("E"), relative)
    assert normal_reflectance(*index) == pytest.approx(found, rel=5e-3)


BOUND = {
    # Percent, r g b: the largest over FL1 to FL12, as docs/light.md states.
    ("titanium", "nikon_d5100"): (0.7, 1.8, 0.4),
    ("titanium", None): (2.1, 0.9, 0.3),
    ("titanium_palm", "nikon_d5100"): (1.1, 2.6, 0.5),
    ("titanium_rakic", "nikon_d5100"): (0.3, 0.5, 0.2),
    ("titanium_werner_dft", "nikon_d5100"): (0.4, 1.2, 0.4),
    ("steel_austenitic", "nikon_d5100"): (0.5, 1.4, 0.3),
}


@pytest.mark.parametrize(("metal", "curve"), BOUND)
def test_one_reflectance_for_all_lamps_errs_within_the_stated_bound(metal, curve):
    relative = sensor_response(curve, WAVELENGTHS)
    errors = [np.abs(lamp_dependence(metal, spectrum(name), relative)) for name in FLUORESCENT]
    worst = 100 * np.max(errors, axis=0)
    assert (worst <= BOUND[metal, curve]).all(), worst
    assert (worst >= np.array(BOUND[metal, curve]) - 0.15).all(), f"the bound is loose: {worst}"


@pytest.mark.parametrize("curve", [None, "nikon_d5100"])
def test_titanium_at_the_channels_wavelength_is_near_what_any_tube_sees(curve):
    """What is rendered, n and k at `wavelength_nm`, against the photons counted under FL1-FL12."""
    rendered = normal_reflectance(*at_wavelengths(METALS["titanium"], WAVELENGTHS))
    relative = sensor_response(curve, WAVELENGTHS)
    seen = [effective_reflectance("titanium", spectrum(name), relative) for name in FLUORESCENT]
    assert np.abs(rendered / np.array(seen) - 1).max() < 0.017
