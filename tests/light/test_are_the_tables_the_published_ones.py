"""Are the spectra those of the CIE, and the metals those of the articles?

Chromaticity depends on every number of a spectrum. What CIE 15:2004 and CIE 15:2018 publish beside
the spectra is typed here. CIE sums products of the tables in steps of 5 nm, so does the first test.
"""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from simtip.spectra import (
    METALS,
    VISIBLE_NM,
    MetalName,
    ResponseName,
    SpectrumName,
    at_wavelengths,
    integral,
    luminous_efficacy,
    normal_reflectance,
    observer,
    response,
    spectrum,
    tristimulus,
)
from simtip.spectra.table import columns

PUBLISHED_XY = {
    "A": (0.4476, 0.4074), "D50": (0.3457, 0.3585), "D65": (0.3127, 0.3290),
    "FL1": (0.3131, 0.3371), "FL2": (0.3721, 0.3751), "FL3": (0.4091, 0.3941),
    "FL4": (0.4402, 0.4031), "FL5": (0.3138, 0.3452), "FL6": (0.3779, 0.3882),
    "FL7": (0.3129, 0.3292), "FL8": (0.3458, 0.3586), "FL9": (0.3741, 0.3727),
    "FL10": (0.3458, 0.3588), "FL11": (0.3805, 0.3769), "FL12": (0.4370, 0.4042),
    "FL3.1": (0.4407, 0.4033), "FL3.2": (0.3808, 0.3734), "FL3.3": (0.3153, 0.3439),
    "FL3.4": (0.4429, 0.4043), "FL3.5": (0.3749, 0.3672), "FL3.6": (0.3488, 0.3600),
    "FL3.7": (0.4384, 0.4045), "FL3.8": (0.3820, 0.3832), "FL3.9": (0.3499, 0.3591),
    "FL3.10": (0.3455, 0.3560), "FL3.11": (0.3245, 0.3434), "FL3.12": (0.4377, 0.4037),
    "FL3.13": (0.3830, 0.3724), "FL3.14": (0.3447, 0.3609), "FL3.15": (0.3127, 0.3288),
    "LED-B1": (0.4560, 0.4078), "LED-B2": (0.4357, 0.4012), "LED-B3": (0.3756, 0.3723),
    "LED-B4": (0.3422, 0.3502), "LED-B5": (0.3118, 0.3236), "LED-BH1": (0.4474, 0.4066),
    "LED-RGB1": (0.4557, 0.4211), "LED-V1": (0.4548, 0.4044), "LED-V2": (0.3781, 0.3775),
    "E": (1 / 3, 1 / 3),
}  # fmt: skip

PUBLISHED_V = {450: 0.038, 500: 0.323, 510: 0.503, 555: 1.0, 560: 0.995, 600: 0.631, 650: 0.107}
"""V(lambda), CIE 1924."""

TITANIUM_AT_550_NM = {
    # By hand from the n and k listed nearest to 550 nm (2.54, 3.43; 1.864, 2.074; ..).
    "titanium": 0.5818,
    "titanium_palm": 0.4038,
    "titanium_rakic": 0.5737,
    "titanium_werner_dft": 0.6041,
}


def test_every_name_has_its_table():
    assert set(PUBLISHED_XY) == set(get_args(SpectrumName))
    listed = set(columns("illuminants")) - {"wavelength_nm"}
    assert listed | {"E"} == set(get_args(SpectrumName))
    assert set(METALS) == set(get_args(MetalName)) == {*TITANIUM_AT_550_NM, "steel_austenitic"}
    for name in get_args(ResponseName):
        assert response(name).at(np.array([550.0])).shape == (1, 3)


@pytest.mark.parametrize("name", PUBLISHED_XY)
def test_chromaticity_is_the_published_one(name):
    eye = columns("observer")
    steps = eye["wavelength_nm"]
    assert np.array_equal(steps, np.arange(380, 781, 5))
    power = spectrum(name).at(steps)
    XYZ = np.array([power @ eye[axis] for axis in "xyz"])
    # Four digits are printed. The full tables of A and D go on to 830 nm; the LEDs were summed
    # in steps of 1 nm.
    tolerance = 3e-4 if name.startswith("LED") else 1.01e-4
    assert XYZ[:2] / XYZ.sum() == pytest.approx(PUBLISHED_XY[name], abs=tolerance)


@pytest.mark.parametrize("name", PUBLISHED_XY)
def test_straight_lines_between_the_steps_change_little(name):
    XYZ = tristimulus(spectrum(name))
    assert XYZ[:2] / XYZ.sum() == pytest.approx(PUBLISHED_XY[name], abs=6e-4)


def test_the_eye_is_the_published_one():
    found = observer().at(np.array(list(PUBLISHED_V), dtype=float))[:, 1]
    assert found == pytest.approx(list(PUBLISHED_V.values()), abs=5e-4)
    assert observer().at(np.array([555.0]))[0, 1] == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("name", PUBLISHED_XY)
def test_a_spectrum_is_one_watt_and_never_negative(name):
    light = spectrum(name)
    assert float(integral(light.at, light)) == pytest.approx(1, rel=1e-12)
    fine = light.at(np.linspace(*VISIBLE_NM, 4001))
    assert fine.min() >= 0
    assert float(np.trapezoid(fine, dx=0.1)) == pytest.approx(1, rel=1e-9)


def test_luminous_efficacy_is_of_the_known_size():
    """Of radiation: 338 lm/W or so for cool white (FL2), 155 for illuminant A over 380-780 nm."""
    assert luminous_efficacy("FL2") == pytest.approx(337, abs=2)
    assert luminous_efficacy("A") == pytest.approx(156, abs=2)
    # Equal energy: K_m times the integral of V, 106.857 nm, over 400 nm.
    assert luminous_efficacy("E") == pytest.approx(683.002 * 106.857 / 400, rel=1e-4)


@pytest.mark.parametrize("name", TITANIUM_AT_550_NM)
def test_titanium_reflects_as_its_article_says(name):
    found = float(normal_reflectance(*at_wavelengths(METALS[name], 550)))
    assert found == pytest.approx(TITANIUM_AT_550_NM[name], abs=1e-3)
    assert 0.40 <= found <= 0.61


def test_the_default_titanium_has_johnson_and_christys_numbers():
    table = METALS["titanium"]
    typed = {0.451: (2.27, 3.04), 0.549: (2.54, 3.43), 0.617: (2.67, 3.72), 0.704: (2.86, 3.96)}
    for um, nk in typed.items():
        assert tuple(table[table[:, 0] == um][0, 1:]) == nk


def test_every_metal_covers_the_visible():
    for name, table in METALS.items():
        assert (np.diff(table[:, 0]) > 0).all(), name
        assert table[0, 0] * 1000 <= VISIBLE_NM[0], name
        assert table[-1, 0] * 1000 >= VISIBLE_NM[1], name
        assert table[:, 1:].min() > 0.5, name
        assert table[:, 1:].max() < 6, name
