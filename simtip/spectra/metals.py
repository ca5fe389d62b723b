"""Metals: n and k by wavelength, and what a channel sees of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array
from simtip.spectra.channels import photon_mean
from simtip.spectra.curve import Curve
from simtip.spectra.light import spectrum
from simtip.spectra.names import MetalName
from simtip.spectra.table import columns


class _Metals(Mapping[str, Array]):
    """Read each table when it is first asked for."""

    def __getitem__(self, name: str) -> Array:
        if name not in get_args(MetalName):
            raise KeyError(name)
        table = columns(f"metal_{name}")
        return np.stack([table[k] for k in ("wavelength_um", "n", "k")], axis=-1)

    def __iter__(self) -> Iterator[str]:
        return iter(get_args(MetalName))

    def __len__(self) -> int:
        return len(get_args(MetalName))


METALS: Mapping[str, Array] = _Metals()
"""Tables by name: rows of wavelength (um), n, k. Sources stand in ``tables/metal_<name>.csv``."""


def at_wavelengths(table: Array, wavelength_nm: ArrayLike) -> tuple[Array, Array]:
    """Interpolate (n, k) linearly at wavelengths in nm; the end values hold beyond the table."""
    um = np.asarray(wavelength_nm, dtype=np.float64) / 1000
    return np.interp(um, table[:, 0], table[:, 1]), np.interp(um, table[:, 0], table[:, 2])


def normal_reflectance(n: ArrayLike, k: ArrayLike) -> Array:
    """Fresnel reflectance at normal incidence from air."""
    n, k = np.asarray(n, dtype=np.float64), np.asarray(k, dtype=np.float64)
    reflectance: Array = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    return reflectance


def effective_index(metal: MetalName, light: Curve, relative: Curve) -> tuple[Array, Array]:
    """Give n (3,) and k (3,): each channel's mean over the photons it counts.

    Parameters
    ----------
    metal
        Which table.
    light
        The lamp, or equal energy for a value that serves all lamps.
    relative
        The sensor's relative quantum efficiency, (n, 3).
    """
    table = METALS[metal]
    n = photon_mean(lambda nm: at_wavelengths(table, nm)[0], light, relative)
    k = photon_mean(lambda nm: at_wavelengths(table, nm)[1], light, relative)
    return n, k


def effective_reflectance(metal: MetalName, light: Curve, relative: Curve) -> Array:
    """Give each channel's normal reflectance (3,), the share of its photons that come back."""
    table = METALS[metal]
    return photon_mean(lambda nm: normal_reflectance(*at_wavelengths(table, nm)), light, relative)


def lamp_dependence(metal: MetalName, light: Curve, relative: Curve) -> Array:
    """Give what is neglected (3,) by giving a metal one reflectance whatever the lamp.

    The relative error of a channel's reflectance under equal energy against that under the lamp.
    """
    true = effective_reflectance(metal, light, relative)
    return effective_reflectance(metal, spectrum("E"), relative) / true - 1
