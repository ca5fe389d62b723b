"""Optical constants of metals.

Titanium: P. B. Johnson and R. W. Christy, "Optical constants of transition metals", Phys. Rev. B 9,
5056 (1974), as listed by refractiveindex.info (CC0).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

METALS: dict[str, Array] = {
    # wavelength um, n, k
    "titanium": np.array(
        [
            [0.397, 2.08, 2.95],
            [0.413, 2.14, 2.98],
            [0.431, 2.21, 3.01],
            [0.451, 2.27, 3.04],
            [0.471, 2.32, 3.10],
            [0.496, 2.36, 3.19],
            [0.521, 2.44, 3.30],
            [0.549, 2.54, 3.43],
            [0.582, 2.60, 3.58],
            [0.617, 2.67, 3.72],
            [0.659, 2.76, 3.84],
            [0.704, 2.86, 3.96],
        ]
    )
}


def at_wavelengths(table: Array, wavelength_nm: ArrayLike) -> tuple[Array, Array]:
    """Interpolate (n, k) linearly at wavelengths in nm; the end values hold beyond the table."""
    um = np.asarray(wavelength_nm, dtype=np.float64) / 1000
    return np.interp(um, table[:, 0], table[:, 1]), np.interp(um, table[:, 0], table[:, 2])


def normal_reflectance(n: ArrayLike, k: ArrayLike) -> Array:
    """Fresnel reflectance at normal incidence from air."""
    n, k = np.asarray(n, dtype=np.float64), np.asarray(k, dtype=np.float64)
    reflectance: Array = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    return reflectance
