"""Closed forms of what a lens does, written without the code under test. Lengths in px."""

from __future__ import annotations

import numpy as np
from scipy import special


def optical_transfer(f, airy_unit, sigma):
    """Incoherent diffraction of a circular pupil times a Gaussian, f in cycles per px.

    Goodman: (2/pi) (acos x - x sqrt(1 - x^2)), x = f lambda N; `airy_unit` is lambda N, 0 for none.
    """
    f = np.abs(f)
    x = np.clip(f * airy_unit, 0, 1)
    diffraction = 2 / np.pi * (np.arccos(x) - x * np.sqrt(1 - x * x))
    return diffraction * np.exp(-2 * (np.pi * sigma * f) ** 2)


def over_pixels(u, v, airy_unit, sigma, aliases=8):
    """Transfer function of the PSF integrated over pixels: its spectrum times sinc, aliased."""
    k = np.arange(-aliases, aliases + 1)
    fu, fv = np.meshgrid(u + k, v + k)
    H = optical_transfer(np.hypot(fu, fv), airy_unit, sigma)
    return float((H * np.sinc(fu) * np.sinc(fv)).sum())


def transfer_of(kernel, u, v):
    """Fourier transform of a kernel around its middle element, complex: a shift would show."""
    lags = np.arange(len(kernel)) - len(kernel) // 2
    return np.exp(-2j * np.pi * v * lags) @ kernel @ np.exp(-2j * np.pi * u * lags)


def airy_moments(airy_unit, radius, rings=40_000, spokes=181):
    """Second moments on one axis of the cut Airy pattern: (its own, once rounded to pixels)."""
    r = (np.arange(rings) + 0.5) / rings * radius
    weight = (special.j1(np.pi * r / airy_unit) / r) ** 2 * r
    angle = (np.arange(spokes) + 0.5) * (np.pi / 2) / spokes
    x = r[:, None] * np.cos(angle)
    weight = weight[:, None] / (weight.sum() * spokes)
    return float((weight * x**2).sum()), float((weight * np.rint(x) ** 2).sum())


PER_PX, LENGTH = 16, 512


def edge_profiles(airy_unit, sigma, phase):
    """A sharp edge at `phase` px from a pixel's centre, rising, blurred exactly.

    Sixteen samples per pixel; integrated over pixels; a second, falling edge far away closes it.

    Returns
    -------
    sharp, blurred
        At the pixels, (512,); the edge is at 256 + phase.
    """
    x = np.arange(LENGTH * PER_PX) / PER_PX
    sharp = pixel_edge(x, phase)
    f = np.fft.fftfreq(x.size, 1 / PER_PX)
    blurred = np.fft.ifft(np.fft.fft(sharp) * optical_transfer(f, airy_unit, sigma)).real
    return sharp[::PER_PX], blurred[::PER_PX]


def pixel_edge(x, phase, width=1.0):
    """The edges of `edge_profiles`, integrated over pixels `width` wide, at any place x."""
    rise, fall = LENGTH / 2 + phase, LENGTH + phase
    steps = [np.clip((x - at) / width + 0.5, 0, 1) for at in (rise, fall, fall - LENGTH)]
    return steps[0] - steps[1] + 1 - steps[2]  # the falling edge is also at the other end
