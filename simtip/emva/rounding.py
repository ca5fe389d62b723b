"""What rounding to whole DN does to a mean and a variance.

Rounding adds 1/12 DN^2 and nothing else as long as the noise reaches over a few codes. With less
noise it adds a ripple that depends on where between two codes the signal lies. For normal noise
of variance s2 (DN^2) about the mean m, the first term of its Fourier series is, with
``g = exp(-2 pi^2 s2)``, ``g sin(2 pi m) / pi`` on the mean and ``(4 s2 + 1 / pi^2) g cos(2 pi m)``
on the variance, signs apart (Sripad and Snyder 1977, IEEE Trans. ASSP 25:5). Pixels whose means
differ average the ripple out by a like factor of their spatial variance.

The phase is not known, so the ripple is taken as an error of mean 0 and known size.
"""

from __future__ import annotations

import math

import numpy as np

from simtip.emva.estimate import Array

ROUNDING_DN2 = 1 / 12
"""Variance that rounding adds (EMVA 1288: sigma_q^2)."""

LEAST_VARIANCE_DN2 = 0.24
"""EMVA 1288: below this temporal variance, rounding included, dark noise is not resolved."""


def ripple(noise_dn2: Array, spatial_dn2: Array | float = 0.0) -> Array:
    """Give g, between 0 and 1: how far rounding is from plain added noise.

    Parameters
    ----------
    noise_dn2
        Temporal variance before rounding, DN^2.
    spatial_dn2
        Variance of the pixels' means among each other, DN^2.
    """
    spread = np.maximum(noise_dn2, 0) + np.maximum(spatial_dn2, 0)
    g: Array = np.exp(-2 * np.pi**2 * spread)
    return g


def mean_error(noise_dn2: Array, spatial_dn2: Array | float = 0.0) -> Array:
    """Give the standard deviation over all phases of the error of a mean, DN."""
    error: Array = ripple(noise_dn2, spatial_dn2) / (np.pi * np.sqrt(2))
    return error


def variance_error(noise_dn2: Array, spatial_dn2: Array | float = 0.0) -> Array:
    """Give the standard deviation over all phases of the error of a temporal variance, DN^2."""
    amplitude: Array = 4 * np.maximum(noise_dn2, 0) + 1 / np.pi**2
    error: Array = amplitude * ripple(noise_dn2, spatial_dn2) / np.sqrt(2)
    return error


def spatial_error(noise_dn2: float, spatial_dn2: float) -> float:
    """Give the size of the error of a mean frame's spatial variance, DN^2.

    The ripple stretches the differences between pixels by up to ``1 + 2 g``, and adds a variance
    of its own of at most ``g^2 / (2 pi^2)``.
    """
    g = float(ripple(np.array(noise_dn2)))
    damped = float(ripple(np.array(noise_dn2), spatial_dn2))
    return 4 * max(spatial_dn2, 0) * damped / math.sqrt(2) + g**2 / (2 * math.pi**2)
