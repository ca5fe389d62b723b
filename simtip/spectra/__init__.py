"""Spectra as tables: lamps, the eye, sensors, metals; and what a sensor's channels make of them.

All over 380 to 780 nm. Needs numpy only; a table is read when it is first asked for. Sources stand
in the tables themselves, in ``simtip/spectra/tables``.
"""

from simtip.spectra.channels import (
    bands,
    channel_weights,
    effective_wavelength,
    peak_factor,
    photon_mean,
    response,
    sensor_response,
)
from simtip.spectra.curve import VISIBLE_NM, Curve, integral, tabulated
from simtip.spectra.light import (
    LUMENS_PER_WATT,
    luminous_efficacy,
    observer,
    spectrum,
    tristimulus,
)
from simtip.spectra.metals import (
    METALS,
    at_wavelengths,
    effective_index,
    effective_reflectance,
    lamp_dependence,
    normal_reflectance,
)
from simtip.spectra.names import MetalName, ResponseName, SpectrumName

__all__ = [
    "LUMENS_PER_WATT",
    "METALS",
    "VISIBLE_NM",
    "Curve",
    "MetalName",
    "ResponseName",
    "SpectrumName",
    "at_wavelengths",
    "bands",
    "channel_weights",
    "effective_index",
    "effective_reflectance",
    "effective_wavelength",
    "integral",
    "lamp_dependence",
    "luminous_efficacy",
    "normal_reflectance",
    "observer",
    "peak_factor",
    "photon_mean",
    "response",
    "sensor_response",
    "spectrum",
    "tabulated",
    "tristimulus",
]
