"""Metals as the renderer asks for them: n and k per channel, and the tint of an oxide film."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.spec import SensorSpec
from simtip.spectra import (
    METALS,
    MetalName,
    at_wavelengths,
    effective_index,
    normal_reflectance,
    sensor_response,
    spectrum,
)

__all__ = ["METALS", "at_wavelengths", "channel_index", "film_tint", "normal_reflectance"]


def channel_index(metal: MetalName, sensor: SensorSpec) -> tuple[Array, Array]:
    """Give n (3,) and k (3,) of a metal as the sensor's channels see it.

    With a spectral response, the mean over the photons that a channel counts under equal energy;
    else the values at the channels' wavelengths.
    """
    if sensor.spectral_response is None:
        return at_wavelengths(METALS[metal], sensor.wavelength_nm)
    relative = sensor_response(sensor.spectral_response, sensor.wavelength_nm)
    return effective_index(metal, spectrum("E"), relative)


def film_tint(n: Array, k: Array, thickness_nm: float, sensor: SensorSpec) -> Array | None:
    """Give the factor (3,) by which a TiO2 film changes the normal reflectance; None for no film.

    Interference in one film (Airy's sum; Born and Wolf, "Principles of Optics", 1.6), at normal
    incidence for all angles. Index of rutile, ordinary ray: J. R. DeVore, J. Opt. Soc. Am. 41, 416
    (1951); anodic films are less dense, so that a real one is some 10 to 15 % thicker for the same
    colour.

    Parameters
    ----------
    n, k
        (3,) of the metal.
    thickness_nm
        Of the film.
    sensor
        Its wavelengths count.
    """
    if thickness_nm == 0:
        return None
    wavelength_nm = np.array(sensor.wavelength_nm)
    tint = film_reflectance(n, k, thickness_nm, wavelength_nm) / normal_reflectance(n, k)
    return np.asarray(tint)


def rutile_index(wavelength_nm: ArrayLike) -> Array:
    """Give the index of TiO2 by DeVore's formula, in its range of 430 to 1530 nm (clipped)."""
    um2 = (np.maximum(np.asarray(wavelength_nm, dtype=np.float64), 430) / 1000) ** 2
    return np.asarray(np.sqrt(5.913 + 0.2441 / (um2 - 0.0803)))


def film_reflectance(
    n: ArrayLike, k: ArrayLike, thickness_nm: float, wavelength_nm: ArrayLike
) -> Array:
    """Give the reflectance of a metal under a TiO2 film at normal incidence."""
    film = rutile_index(wavelength_nm)
    metal: NDArray[np.complex128] = np.asarray(n) + 1j * np.asarray(k)
    outer = (1 - film) / (1 + film)
    inner = (film - metal) / (film + metal)
    phase = np.exp(4j * np.pi * film * thickness_nm / np.asarray(wavelength_nm))
    amplitude = (outer + inner * phase) / (1 + outer * inner * phase)
    return np.asarray(np.abs(amplitude) ** 2)
