"""Light: irradiance to photons to electrons, on average."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.sensor.real import Array, Real
from simtip.spec import SensorSpec

PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_S = 299792458.0


def photons(
    irradiance_w_m2: NDArray[Real],
    pixel_um: float,
    exposure_s: float,
    wavelength_nm: ArrayLike,
) -> NDArray[np.floating[Any]]:
    """Give the mean photons on a pixel, ``mu_p = A E t lambda / (h c)`` (EMVA 1288, Eq. 2).

    Parameters
    ----------
    irradiance_w_m2
        E, (..., 3) W m^-2.
    pixel_um
        Side of the square pixel; A is its area.
    exposure_s
        t.
    wavelength_nm
        Effective wavelength lambda of each channel, (3,).
    """
    area_m2 = (pixel_um * 1e-6) ** 2
    wavelength_m = np.asarray(wavelength_nm, dtype=np.float64) * 1e-9
    per_irradiance = area_m2 * exposure_s * wavelength_m / (PLANCK_J_S * LIGHT_SPEED_M_S)
    return irradiance_w_m2 * per_irradiance.astype(irradiance_w_m2.dtype)


def electrons(
    photons_mean: NDArray[np.floating[Any]], quantum_efficiency: ArrayLike
) -> NDArray[np.floating[Any]]:
    """Give the mean electrons, ``mu_e = eta mu_p`` (EMVA 1288, Eq. 1); eta is (3,)."""
    return photons_mean * np.asarray(quantum_efficiency, dtype=photons_mean.dtype)


def responsivity(spec: SensorSpec) -> Array:
    """Give the mean photo-electrons per unit of irradiance, (3,) e- / (W m^-2)."""
    mu_p = photons(np.ones(3), spec.pixel_um, spec.exposure_s, spec.wavelength_nm)
    return electrons(mu_p, spec.quantum_efficiency).astype(np.float64)


def mean_electrons(irradiance_w_m2: ArrayLike, spec: SensorSpec) -> Array:
    """Give the photo-electrons of an average pixel, without dark ones, whatever the full well.

    Parameters
    ----------
    irradiance_w_m2
        (H, W, 3) W m^-2 per channel.
    spec
        The sensor.

    Returns
    -------
    electrons
        (H, W, 3) float64, e-.

    Raises
    ------
    ValueError
        Another shape, or an irradiance that is negative or not finite.
    """
    return checked(irradiance_w_m2).astype(np.float64) * responsivity(spec)


def checked(irradiance_w_m2: ArrayLike) -> NDArray[Any]:
    """Give the irradiance as (H, W, 3) float32 or float64, or raise ValueError."""
    light: NDArray[Any] = np.asarray(irradiance_w_m2)
    if light.ndim != 3 or light.shape[2] != 3 or not light.size:
        raise ValueError(f"irradiance has the shape (H, W, 3), not {light.shape}")
    if light.dtype.kind not in "fiu":
        raise ValueError(f"irradiance is real numbers, not {light.dtype}")
    if light.dtype != np.float32:
        light = light.astype(np.float64)
    # NaN passes through min and max, and compares as false.
    if not (light.min() >= 0 and light.max() < np.inf):
        raise ValueError("irradiance has a value that is negative or not finite")
    return light
