"""The exposure time that brings the background to a wanted gray level."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from simtip.errors import InputError
from simtip.sensor import UNIFORM, expected_dn
from simtip.spec import SensorSpec

GRAY = np.array([0.299, 0.587, 0.114])
"""Weights of the gray level, ITU-R BT.601, as detectors commonly use them."""

SHORTEST_S, LONGEST_S = 1e-6, 100.0


def background_irradiance(
    irradiance: NDArray[np.float32], coverage: NDArray[np.float32]
) -> NDArray[np.float64]:
    """Give the median irradiance (3,), W m^-2, of pixels (H, W, 3) that the needle does not touch.

    All pixels count if it touches all.
    """
    free = coverage == 0
    pixels = irradiance[free] if free.any() else irradiance.reshape(-1, 3)
    return np.median(pixels, axis=0).astype(np.float64)


def gray_level(irradiance: NDArray[np.float64], sensor: SensorSpec) -> float:
    """Give the expected gray level, DN, of an even irradiance (3,), W m^-2."""
    dn = expected_dn(irradiance.reshape(1, 1, 3), sensor, camera=UNIFORM)
    return float(dn[0, 0] @ GRAY)


def auto_expose(irradiance: NDArray[np.float64], sensor: SensorSpec) -> SensorSpec:
    """Set the exposure time so that the background has the gray level `sensor.background_dn`.

    Parameters
    ----------
    irradiance
        (3,) of the background, W m^-2: the mean over both cameras' `background_irradiance`.
    sensor
        What `background_dn` it asks for; without one it is returned as it is.

    Raises
    ------
    InputError
        No exposure from 1 us to 100 s gives that level.
    """
    wanted = sensor.background_dn
    if wanted is None:
        return sensor

    target = float(wanted)

    def excess(log_s: float) -> float:
        return gray_level(irradiance, _timed(sensor, float(np.exp(log_s)))) - target

    ends = float(np.log(SHORTEST_S)), float(np.log(LONGEST_S))
    lowest, highest = excess(ends[0]), excess(ends[1])
    if not (lowest < 0 < highest):
        raise InputError(
            f"{wanted:g} DN cannot be reached: exposures from 1 us to 100 s give "
            f"{lowest + wanted:.1f} to {highest + wanted:.1f} DN",
            field="sensor.background_dn",
            remedy="ask for another level, or change the light or the gain",
        )
    return _timed(sensor, float(np.exp(brentq(excess, *ends, xtol=1e-10))))


def _timed(sensor: SensorSpec, exposure_s: float) -> SensorSpec:
    return sensor.model_copy(update={"exposure_s": exposure_s})
