"""From collected electrons to digital numbers, one function per step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.sensor.real import Array, Real
from simtip.spec import SensorSpec

Image = NDArray[np.uint8] | NDArray[np.uint16]
"""(H, W, 3) DN: uint8 at 8 bit, uint16 above."""


def saturate(collected_e: NDArray[Real], full_well_e: float) -> NDArray[Real]:
    """Clip electrons at the full well: after shot noise, DSNU and dark current, before reading.

    So a full pixel is full whatever its light, and only read noise still moves it.
    """
    return np.minimum(collected_e, full_well_e)


def read_noise(
    collected_e: NDArray[Real], read_noise_e: float, rng: np.random.Generator
) -> NDArray[Real]:
    """Add the dark noise of the read-out: normal, standard deviation sigma_d in e-."""
    noise = rng.standard_normal(collected_e.shape, dtype=collected_e.dtype)
    return collected_e + noise * read_noise_e


def gains(spec: SensorSpec) -> Array:
    """Give each channel's system gain (3,), DN/e-: K times its white balance."""
    return spec.gain_dn_per_e * np.array(spec.white_balance)


def amplify(
    collected_e: NDArray[Real], gain_dn_per_e: float | NDArray[Real], black_level_dn: float
) -> NDArray[Real]:
    """Turn electrons into DN, not yet whole: ``K e + black level``; K one, or one a value."""
    return collected_e * gain_dn_per_e + black_level_dn


def gamma_curve(dn: NDArray[Real], gamma: float, bit_depth: int) -> NDArray[Real]:
    """Bend the output, DN not yet whole: ``top (dn / top)^gamma``, within 0 .. top = 2^bits - 1.

    As in machine-vision cameras (GenICam SFNC, "Gamma"): 1 changes nothing, 0.45 suits a display.
    It rises from 0 to the top code, both fixed; the black level is bent like everything else. What
    is below 0 or above the top code is clipped here rather than when it is rounded.
    """
    top = 2**bit_depth - 1
    bent: NDArray[Real] = np.clip(dn, 0, top) / top
    np.power(bent, gamma, out=bent)
    bent *= top
    return bent


def linear_dn(dn: NDArray[Real], gamma: float, bit_depth: int) -> NDArray[Real]:
    """Undo `gamma_curve` for values within 0 .. 2^bits - 1."""
    return gamma_curve(dn, 1 / gamma, bit_depth)


def quantise(dn: NDArray[Real], bit_depth: int) -> Image:
    """Round to the nearest whole DN (halves to even) and clip to 0 .. 2^bits - 1.

    This is all of the quantisation noise: nothing is added for it elsewhere.
    """
    whole = np.rint(dn)
    np.clip(whole, 0, 2**bit_depth - 1, out=whole)
    return whole.astype(np.uint8) if bit_depth <= 8 else whole.astype(np.uint16)
