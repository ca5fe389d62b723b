"""Spectra of lamps, and how bright they look."""

from __future__ import annotations

from functools import cache

import numpy as np

from simtip.geometry import Array
from simtip.spectra.curve import VISIBLE_NM, Curve, integral, tabulated
from simtip.spectra.names import SpectrumName
from simtip.spectra.table import columns

LUMENS_PER_WATT = 683.002
"""K_m, lm/W, of the standard photometric observer (CIE 018:2019)."""


@cache
def spectrum(name: SpectrumName) -> Curve:
    """Give the spectral power of a lamp of one watt, W/nm, from 380 to 780 nm.

    CIE illuminants in steps of 5 nm, with straight lines between; mercury lines are as broad as
    that.
    """
    if name == "E":
        ends = np.array(VISIBLE_NM)
        return tabulated(ends, np.full(2, 1 / (ends[1] - ends[0])))
    table = columns("illuminants")
    relative = tabulated(table["wavelength_nm"], table[name])
    watts = float(integral(relative.at, relative))
    return tabulated(table["wavelength_nm"], table[name] / watts)


@cache
def observer() -> Curve:
    """Give the CIE 1931 colour matching functions x y z; y is V(lambda) of CIE 1924."""
    table = columns("observer")
    return tabulated(table["wavelength_nm"], np.stack([table[k] for k in "xyz"], axis=-1))


def tristimulus(light: Curve) -> Array:
    """Give X Y Z (3,) of a spectrum; of one watt, Y times `LUMENS_PER_WATT` is lm/W."""
    eye = observer()
    return integral(lambda nm: light.at(nm)[:, None] * eye.at(nm), light, eye)


@cache
def luminous_efficacy(name: SpectrumName) -> float:
    """Give the luminous efficacy of a lamp's visible radiation, lm/W."""
    return LUMENS_PER_WATT * float(tristimulus(spectrum(name))[1])
