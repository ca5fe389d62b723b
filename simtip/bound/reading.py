"""What one reading of a pixel tells about the light on it.

A reading is taken as normal about its mean mu (electrons) with the variance of EMVA 1288,
``mu + sigma_d^2 + (1/12) / (dDN/de)^2``: shot noise of light and dark current, read noise,
rounding. Beyond the sensor's range it only says that it is beyond.

The Fisher information about mu of such a censored normal reading, known where the range ends, is

    ``(1 / var) ( [Phi(t) - t phi(t)]_a^b + phi(a)^2 / Phi(a) + phi(b)^2 / (1 - Phi(b)) )``

with a, b the ends of the range in standard deviations from mu: 1 / var well inside, 0 far outside.
That the variance depends on mu is left out: it would add 1 / (2 var^2), which the Poisson
distribution does not have (its information is 1 / mu exactly).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from simtip.geometry import Array
from simtip.sensor import gains
from simtip.spec import SensorSpec

ROUNDING_DN2 = 1 / 12
HALF_CODE = 0.5


def reading_information(collected_e: ArrayLike, sensor: SensorSpec) -> Array:
    """Give the Fisher information of one reading about the mean electrons of its pixel.

    Parameters
    ----------
    collected_e
        (..., 3) mean electrons, of light and dark current, whatever the full well; e-.
    sensor
        Its noise, gains, range and gamma; fixed patterns are not looked at.

    Returns
    -------
    information
        (..., 3) e-^-2.
    """
    mean = np.asarray(collected_e, dtype=np.float64)
    variance = reading_variance_e2(mean, sensor)
    spread = np.sqrt(variance)
    low, high = _range_e(sensor)
    return _uncensored((low - mean) / spread, (high - mean) / spread) / variance


def reading_variance_e2(collected_e: Array, sensor: SensorSpec) -> Array:
    """Give the variance (..., 3) of readings, in e-^2, for mean electrons (..., 3)."""
    shot = sensor.noise and sensor.effects.shot_noise
    read = sensor.noise and sensor.effects.read_noise
    temporal = np.maximum(collected_e, 0.0) * shot + sensor.read_noise_e**2 * read
    gain = gains(sensor)
    top = 2**sensor.bit_depth - 1
    share = np.clip((gain * collected_e + sensor.black_level_dn) / top, 0.5 / top, 1.0)
    slope = gain * sensor.gamma * share ** (sensor.gamma - 1)
    return np.asarray(temporal + ROUNDING_DN2 / slope**2)


def _range_e(sensor: SensorSpec) -> tuple[Array, Array]:
    """Give the electrons (3,) at which the lowest code ends and the highest begins."""
    gain = gains(sensor)
    top = 2**sensor.bit_depth - 1
    low, high = (top * (code / top) ** (1 / sensor.gamma) for code in (HALF_CODE, top - HALF_CODE))
    ceiling = (high - sensor.black_level_dn) / gain
    if sensor.effects.full_well:
        ceiling = np.minimum(ceiling, sensor.full_well_e)
    return np.asarray((low - sensor.black_level_dn) / gain), np.asarray(ceiling)


def _uncensored(a: Array, b: Array) -> Array:
    """Give what part of its information a standard normal keeps that is read between a and b."""
    inside = special.ndtr(b) - b * _density(b) - special.ndtr(a) + a * _density(a)
    ends = np.exp(2 * _log_density(a) - special.log_ndtr(a)) + np.exp(
        2 * _log_density(b) - special.log_ndtr(-b)
    )
    return np.asarray(inside + ends)


def _density(t: Array) -> Array:
    return np.asarray(np.exp(_log_density(t)))


def _log_density(t: Array) -> Array:
    return np.asarray(-(t**2) / 2 - np.log(2 * np.pi) / 2)
