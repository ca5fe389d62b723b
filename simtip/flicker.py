"""Ripple of lamps on the mains, averaged over an exposure.

A fluorescent tube on a magnetic ballast goes bright with every half wave of the mains, so its
light ripples at twice the mains frequency. The relative output is ``1 + s h(x)``: h is the
waveform with mean 0 and period 2 pi, x the ripple's angle, and s follows from the ripple, the
modulation depth ``(max - min) / (max + min)`` of the output ("percent flicker" over 100 in IEEE
Std 1789-2015 and in the IES Lighting Handbook). The mean over whole periods is always 1, so ripple
changes no lamp's mean power.

Every waveform has its mean over a window [t, t + T] in closed form, from the integral of h.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

WaveformKind = Literal["cosine", "rectified_sine", "harmonics"]

_STEPS = 64  # grid points per period of the highest harmonic, when its extremes are looked for


@dataclass(frozen=True)
class Waveform:
    r"""The shape of a ripple, without depth or phase.

    Attributes
    ----------
    kind
        ``cosine``: cos x. ``rectified_sine``: \|cos(x / 2)\|, the absolute value of a sine of mains
        frequency. ``harmonics``: ``sum a_k cos(k x + p_k)``. The first two peak at x = 0.
    harmonics
        (a_k, p_k) of k = 1, 2, .., relative amplitude and phase in degrees.
    """

    kind: WaveformKind = "cosine"
    harmonics: tuple[tuple[float, float], ...] = ()

    def value(self, angle: ArrayLike) -> Array:
        """Give h at angles x in radians: mean 0, and 1 + h is never below 0 for the first two."""
        x = np.asarray(angle, dtype=np.float64)
        if self.kind == "cosine":
            return np.asarray(np.cos(x))
        if self.kind == "rectified_sine":
            return np.asarray(np.pi / 2 * np.abs(np.cos(x / 2)) - 1)
        return self._series(x, lambda k, a, p: a * np.cos(k * x + p))

    def integral(self, angle: ArrayLike) -> Array:
        """Give the integral of h up to x in radians; it has the period 2 pi too."""
        x = np.asarray(angle, dtype=np.float64)
        if self.kind == "cosine":
            return np.asarray(np.sin(x))
        if self.kind == "rectified_sine":
            # |cos| of x / 2 is cos between -pi/2 and pi/2: one such arch for every 2 pi of x.
            within = x - 2 * np.pi * np.round(x / (2 * np.pi))
            return np.asarray(np.pi * np.sin(within / 2) - within)
        return self._series(x, lambda k, a, p: a / k * np.sin(k * x + p))

    def _series(self, x: Array, term: Callable[[int, float, float], Array]) -> Array:
        total = np.zeros(x.shape)
        for k, (amplitude, phase_deg) in enumerate(self.harmonics, start=1):
            total += term(k, amplitude, np.deg2rad(phase_deg))
        return total

    def extremes(self) -> tuple[float, float]:
        """Give the least and greatest h; a sum of harmonics is searched (to 1e-9 of its range)."""
        if self.kind == "cosine":
            return -1.0, 1.0
        if self.kind == "rectified_sine":
            return -1.0, np.pi / 2 - 1
        steps = _STEPS * len(self.harmonics)
        x = 2 * np.pi * np.arange(steps) / steps
        width = 2 * np.pi / steps
        found = []
        for sign in (-1.0, 1.0):
            peak = x[np.argmax(sign * self.value(x))]
            half = width
            while half > 1e-6:  # an extreme is flat: an angle to 1e-6 makes its height to 1e-12
                near = peak + np.linspace(-half, half, 21)
                peak = near[np.argmax(sign * self.value(near))]
                half /= 10
            found.append(float(self.value(peak)))
        return found[0], found[1]

    def swing(self, ripple: float) -> float:
        """Give the s that makes ``1 + s h`` have the modulation depth `ripple`, 0 to 1."""
        low, high = self.extremes()
        return 2 * ripple / ((high - low) - ripple * (high + low))


COSINE = Waveform()


def relative_output(
    start_s: ArrayLike,
    exposure_s: float,
    ripple_hz: float,
    ripple: float,
    phase_deg: float = 0.0,
    waveform: Waveform = COSINE,
) -> Array:
    """Give the mean relative output over windows [start, start + exposure], 1 on average.

    Parameters
    ----------
    start_s
        When the windows begin, s; any shape, e.g. one a row.
    exposure_s
        Their length, s, above 0.
    ripple_hz
        Twice the mains frequency, Hz.
    ripple
        Modulation depth (max - min) / (max + min), 0 to 1.
    phase_deg
        The ripple's angle at t = 0, degrees.
    waveform
        Its shape.

    Returns
    -------
    relative
        Same shape as `start_s`, at least 0.
    """
    start = np.asarray(start_s, dtype=np.float64)
    periods = exposure_s * ripple_hz
    # Whole periods change nothing; without them, the angles keep all their digits.
    begin = 2 * np.pi * np.mod(start * ripple_hz + phase_deg / 360, 1)
    end = begin + 2 * np.pi * (periods % 1)
    area = waveform.integral(end) - waveform.integral(begin)
    return np.asarray(1 + waveform.swing(ripple) * area / (2 * np.pi * periods))
