"""The sensor: radiance to digital numbers, one function per step, in EMVA 1288's symbols.

In order: `irradiance` (W m^-2), `photons` (mu_p), `electrons` (mu_e), `shot_noise` (e-),
`saturate` (full well, e-), `read_noise` (e-), `amplify` (DN, not yet whole), `quantise` (DN).
`expose` runs them all. Arrays of images are (..., 3), red green blue; the steps work on any shape.

Left out so far: vignetting (cos^4 and mechanical), lens transmission, dark current, differences
between pixels (PRNU, DSNU), colour mosaic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from simtip.spec import SensorSpec

Real = TypeVar("Real", np.float32, np.float64)
Array = NDArray[np.float64]

PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_S = 299792458.0

EXACT_BELOW_E = 32.0
"""Means below this many electrons are drawn by NumPy's exact Poisson generator."""

_BLOCK = 16384  # values worked on at a time: they stay in the cache


def irradiance(radiance: NDArray[Real], f_number: float) -> NDArray[Real]:
    """Give the irradiance E of the sensor, W m^-2: ``E = pi L / (4 N^2)``.

    That is a lossless thin lens focused at infinity, on its axis. A lens focused nearer, with
    magnification m, gives E / (1 + m)^2 (7 % less at the paper's 170 mm).

    Parameters
    ----------
    radiance
        L, W m^-2 sr^-1.
    f_number
        N, focal length over aperture.
    """
    return radiance * (np.pi / (4 * f_number**2))


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
    """Give the mean electrons per unit of radiance, (3,) e- / (W m^-2 sr^-1)."""
    E = irradiance(np.ones(3), spec.f_number)
    mu_p = photons(E, spec.pixel_um, spec.exposure_s, spec.wavelength_nm)
    return electrons(mu_p, spec.quantum_efficiency).astype(np.float64)


def mean_electrons(radiance: ArrayLike, spec: SensorSpec) -> Array:
    """Give the electrons that a pixel collects on average, not limited by the full well.

    Parameters
    ----------
    radiance
        (H, W, 3) W m^-2 sr^-1 per channel.
    spec
        The sensor.

    Returns
    -------
    electrons
        (H, W, 3) float64, e-.

    Raises
    ------
    ValueError
        Another shape, or a radiance that is negative or not finite.
    """
    return _checked(radiance).astype(np.float64) * responsivity(spec)


def expected_dn(radiance: ArrayLike, spec: SensorSpec) -> Array:
    """Give the noise-free digital number before rounding, (H, W, 3) float64, within the range.

    It is the mean of what `expose` gives wherever neither the full well nor an end of the range
    is within reach of the noise, and quantisation is finer than it. Errors as `mean_electrons`.
    """
    collected = saturate(mean_electrons(radiance, spec), spec.full_well_e)
    dn = amplify(collected, spec.gain_dn_per_e, spec.black_level_dn)
    return np.clip(dn, 0, 2**spec.bit_depth - 1)


def shot_noise(mean_e: NDArray[Real], rng: np.random.Generator) -> NDArray[Real]:
    """Draw Poisson numbers of electrons.

    Means below `EXACT_BELOW_E` use NumPy's exact generator. Above, a standard normal w is sent
    through the quantile function of the Poisson distribution, expanded in powers of 1/sqrt(mu)
    (Giles 2016, "Algorithm 955", ACM TOMS 42:7), and rounded down. Its distribution is within
    1.3e-5 of Poisson's in total variation at 32 e-, 1.2e-6 at 100 e-, 1.2e-8 at 1000 e-; its
    mean within 1e-9 e-; its variance within 3e-5 of mu. In single precision, rounding adds at
    most mu 2^-24 electrons on average, 6e-4 e- at 10,000 e-.

    Parameters
    ----------
    mean_e
        mu_e, any shape, e-, finite and at least 0.
    rng
        Consumed: a normal for every value, then numbers for the small ones.

    Returns
    -------
    electrons
        Same shape and type, whole numbers.
    """
    normals, exact = rng.spawn(2)
    return _poisson(mean_e, normals, exact)


def _poisson(
    mean_e: NDArray[Real], normals: np.random.Generator, exact: np.random.Generator
) -> NDArray[Real]:
    w = normals.standard_normal(mean_e.shape, dtype=mean_e.dtype)
    mu = np.maximum(mean_e, EXACT_BELOW_E)
    w2 = w * w
    root = np.sqrt(mu)
    first = w2 * (1 / 6) + 1 / 3
    second = w * (w2 * (1 / 72) + 1 / 36)
    third = (w2 * (1 / 270) + 7 / 810) * w2 - 8 / 405
    drawn = np.floor(mu + (root * w + (first + (third / root - second) / root)))
    few = mean_e < EXACT_BELOW_E
    if few.any():
        drawn[few] = exact.poisson(mean_e[few])
    return np.maximum(drawn, 0)


def saturate(collected_e: NDArray[Real], full_well_e: float) -> NDArray[Real]:
    """Clip electrons at the full well: after the shot noise, before the read noise."""
    return np.minimum(collected_e, full_well_e)


def read_noise(
    collected_e: NDArray[Real], read_noise_e: float, rng: np.random.Generator
) -> NDArray[Real]:
    """Add the dark noise of the read-out: normal, standard deviation sigma_d in e-."""
    noise = rng.standard_normal(collected_e.shape, dtype=collected_e.dtype)
    return collected_e + noise * read_noise_e


def amplify(
    collected_e: NDArray[Real], gain_dn_per_e: float, black_level_dn: float
) -> NDArray[Real]:
    """Turn electrons into DN, not yet whole: ``K e + black level``."""
    return collected_e * gain_dn_per_e + black_level_dn


def quantise(dn: NDArray[Real], bit_depth: int) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Round to the nearest whole DN (halves to even) and clip to 0 .. 2^bits - 1."""
    whole = np.clip(np.rint(dn), 0, 2**bit_depth - 1)
    return whole.astype(np.uint8) if bit_depth <= 8 else whole.astype(np.uint16)


def expose(radiance: ArrayLike, spec: SensorSpec, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Take the picture.

    Parameters
    ----------
    radiance
        (H, W, 3) W m^-2 sr^-1 per channel.
    spec
        The sensor. With ``noise: false`` the result is `expected_dn`, rounded.
    rng
        Gives each source of noise a stream of its own (by spawning), so that read noise off
        leaves the shot noise as it was. Generators made alike give the same picture; one used
        twice gives two. The noise belongs to places in the array: a crop has other noise.

    Returns
    -------
    image
        (H, W, 3) uint8, DN.

    Raises
    ------
    ValueError
        Another shape, or a radiance that is negative or not finite.
    """
    light = _checked(radiance)
    height, width, _ = light.shape
    rows = light.reshape(height, width * 3)
    image = np.empty((height, width * 3), dtype=np.uint8)
    per_radiance = np.tile(responsivity(spec), width)
    shot, exact, read = rng.spawn(3)
    step = max(1, _BLOCK // (width * 3))
    for top in range(0, height, step):
        block = rows[top : top + step]
        if spec.noise:
            mean_e = _collected(block, per_radiance.astype(block.dtype), spec).astype(np.float32)
            collected = saturate(_poisson(mean_e, shot, exact), spec.full_well_e)
            collected = read_noise(collected, spec.read_noise_e, read)
        else:
            mean_e = _collected(block.astype(np.float64), per_radiance, spec)
            collected = saturate(mean_e, spec.full_well_e)
        dn = amplify(collected, spec.gain_dn_per_e, spec.black_level_dn)
        image[top : top + step] = quantise(dn, spec.bit_depth)
    return image.reshape(height, width, 3)


def _collected(block: NDArray[Any], per_radiance: NDArray[Any], spec: SensorSpec) -> NDArray[Any]:
    """Give mean electrons up to where the well is full whatever the noise: none overflows."""
    surely_full = spec.full_well_e + 20 * spec.full_well_e**0.5 + 200
    with np.errstate(over="ignore"):
        collected: NDArray[Any] = np.minimum(block * per_radiance, surely_full)
    return collected


def _checked(radiance: ArrayLike) -> NDArray[Any]:
    light: NDArray[Any] = np.asarray(radiance)
    if light.ndim != 3 or light.shape[2] != 3 or not light.size:
        raise ValueError(f"radiance has the shape (H, W, 3), not {light.shape}")
    if light.dtype.kind not in "fiu":
        raise ValueError(f"radiance is real numbers, not {light.dtype}")
    if light.dtype != np.float32:
        light = light.astype(np.float64)
    # NaN passes through min and max, and compares as false.
    if not (light.min() >= 0 and light.max() < np.inf):
        raise ValueError("radiance has a value that is negative or not finite")
    return light
