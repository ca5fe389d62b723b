r"""How a spectrum splits over the three channels of a sensor.

The sensor counts a channel's light as if it all had one wavelength lambda_c: a channel irradiance
E_c makes ``E_c A t eta_c lambda_c / (h c)`` electrons. What really happens is ``A t / (h c) \int
E(lambda) eta_c(lambda) lambda d lambda``. Both agree if a lamp's total irradiance E splits by

``w_c = \int S(lambda) r_c(lambda) lambda d lambda / (lambda_c r_c(lambda_c))``

S being the lamp's spectrum with integral 1, and r_c the relative quantum efficiency, whose scale is
set by eta_c, the sensor's `quantum_efficiency` at its `wavelength_nm`: eta_c(lambda) = eta_c
r_c(lambda) / r_c(lambda_c). So only the shape of r_c matters here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from simtip.geometry import Array
from simtip.spectra.curve import VISIBLE_NM, Curve, integral, tabulated
from simtip.spectra.names import ResponseName
from simtip.spectra.table import columns

Wavelengths = tuple[float, float, float]


@cache
def response(name: ResponseName) -> Curve:
    """Give the relative quantum efficiency of each channel, (n, 3) r g b, peaks of 1."""
    table = columns(f"response_{name}")
    return tabulated(table["wavelength_nm"], np.stack([table[k] for k in "rgb"], axis=-1))


def bands(wavelength_nm: Wavelengths) -> Curve:
    """Give ideal channels: each counts equally all light to which its wavelength is the nearest.

    The three together count every photon of the visible range once; channels of equal wavelength
    have the same band.
    """
    centres = np.array(wavelength_nm)
    apart = np.unique(centres)
    between = (apart[1:] + apart[:-1]) / 2

    def at(nm: Array) -> Array:
        nearest = apart[np.searchsorted(between, nm)]
        own: Array = (nearest[:, None] == centres).astype(np.float64)
        return own

    return Curve(np.concatenate([between, apart]), at)


def sensor_response(name: ResponseName | None, wavelength_nm: Wavelengths) -> Curve:
    """Give a sensor's relative quantum efficiency: a measured one, or ideal `bands` for None."""
    return bands(wavelength_nm) if name is None else response(name)


def peak_factor(relative: Curve, wavelength_nm: Wavelengths) -> Array:
    """Give the greatest r_c over r_c(lambda_c), (3,): inf where the channel is blind."""
    peak = relative.at(relative.breaks_nm).max(axis=0)
    with np.errstate(divide="ignore"):
        return np.asarray(peak / _own(relative, wavelength_nm))


def channel_weights(light: Curve, relative: Curve, wavelength_nm: Wavelengths) -> Array:
    """Give w_c (3,): what of a lamp's power each channel is to count, see the module.

    Parameters
    ----------
    light
        The lamp, W/nm with integral 1.
    relative
        The sensor's relative quantum efficiency, (n, 3).
    wavelength_nm
        The wavelength at which the sensor counts each channel, nm; its response there is above 0.

    Returns
    -------
    weights
        (3,). Their sum is near 1 for ideal bands, and may be anything for real ones.
    """

    def photons(nm: Array) -> Array:
        return light.at(nm)[:, None] * relative.at(nm) * nm[:, None]

    counted = integral(photons, light, relative)
    return np.asarray(counted / (np.array(wavelength_nm) * _own(relative, wavelength_nm)))


def photon_mean(quantity: Callable[[Array], Array], light: Curve, relative: Curve) -> Array:
    """Give each channel's mean (3,) of a function of wavelength (nm) over the photons it counts."""

    def photons(nm: Array) -> Array:
        return light.at(nm)[:, None] * relative.at(nm) * nm[:, None]

    total = integral(lambda nm: photons(nm) * quantity(nm)[:, None], light, relative, _FINE)
    return np.asarray(total / integral(photons, light, relative, _FINE))


def effective_wavelength(light: Curve, relative: Curve) -> Array:
    """Give the mean wavelength (3,), nm, of the photons that each channel counts."""
    return photon_mean(lambda nm: nm, light, relative)


def _own(relative: Curve, wavelength_nm: Wavelengths) -> Array:
    return np.diagonal(relative.at(np.array(wavelength_nm)))


_FINE = Curve(np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1), np.zeros_like)
"""Breaks every nm, for integrands that are more than cubic."""
