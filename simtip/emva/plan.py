"""Which series to take: found by looking at the camera, as an operator would."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from simtip.emva import rounding
from simtip.emva.estimate import Z99
from simtip.emva.frames import Frame, Level, summarise
from simtip.emva.transfer import CLIPPED
from simtip.errors import InputError

_DITHER_DN2 = 0.4
"""Noise at which rounding is harmless (the ripple of a mean is below 1e-4 DN)."""


class Capture(Protocol):
    """A camera on the bench, under even light.

    Called with the mean photons on a pixel during the exposure (0: dark), the exposure time in s
    and a number of frames, it yields that many raw frames, (H, W) uint8 or uint16, of one
    channel. One buffer may be used for all of them.
    """

    def __call__(self, photons: float, exposure_s: float, count: int) -> Iterator[Frame]:
        """Yield the frames."""
        ...


@dataclass(frozen=True)
class Plan:
    """The series to take.

    Attributes
    ----------
    bit_depth
        Bits of the values as stored.
    exposure_s
        Exposure time of the photon transfer, s.
    photons
        Its levels, mean photons on a pixel; 0 (dark) is among them, the last two lie well beyond
        saturation.
    frames
        Frames of each level and each dark exposure; even, as pairs are compared.
    flat_photons, flat_frames
        Levels of the mean frames (dark, weak but off DN 0, half of saturation), and frames of each.
    dark_exposures_s, dark_photons
        Exposure times of the dark series, and its light: 0, or a weak one that lifts a quiet
        camera's noise over the rounding. That light must not depend on the exposure time.
    photons_absolute
        False if photon numbers are only proportional to the true ones.
    """

    bit_depth: int
    exposure_s: float
    photons: tuple[float, ...]
    frames: int
    flat_photons: tuple[float, ...]
    flat_frames: int
    dark_exposures_s: tuple[float, ...]
    dark_photons: float = 0.0
    photons_absolute: bool = True

    @property
    def total_frames(self) -> int:
        """How many frames all series take together."""
        series = len(self.photons) + len(self.dark_exposures_s)
        return series * self.frames + len(self.flat_photons) * self.flat_frames


def plan_measurement(
    capture: Capture,
    *,
    bit_depth: int,
    exposure_s: float,
    frames: int = 8,
    flat_frames: int = 64,
    longest_exposure_s: float = 100.0,
    photons_absolute: bool = True,
) -> Plan:
    """Look for saturation, gain and a visible dark signal with a few frames, and plan from them.

    Levels: twelve closely spaced ones where the noise just covers the rounding (they carry
    sigma_d), thirty even ones to saturation, ten across its edge, two beyond it.

    Parameters
    ----------
    capture
        The camera.
    bit_depth
        Bits of the values as stored.
    exposure_s
        Exposure time of the photon transfer, s: short, so that dark current is small.
    frames, flat_frames
        Frames of a level, and of a mean frame.
    longest_exposure_s
        The dark series goes up to this or to a tenth of the range, whichever comes first.
    photons_absolute
        Passed on.

    Raises
    ------
    InputError
        The camera does not respond to light, or frames that `summarise` refuses.
    """

    def probe(photons: float, at_s: float = exposure_s) -> Level:
        return summarise(
            capture(photons, at_s, 2), photons=photons, exposure_s=at_s, bit_depth=bit_depth
        )

    dark = probe(0.0)
    middle, full = _saturation(probe, dark)
    rise = full.mean_dn - dark.mean_dn
    per_photon = (middle.mean_dn - dark.mean_dn) / middle.photons
    saturation = rise / per_photon
    gain = _rise_dn2(dark, middle) / (middle.mean_dn - dark.mean_dn)
    if gain <= 0:
        raise InputError(
            "the temporal noise does not rise with the light",
            field="frames",
            remedy="give raw frames, without noise reduction or tone curve",
        )
    weak = min(_DITHER_DN2 / gain / per_photon, saturation / 8)
    lifted = _lifted(probe, dark, weak, saturation / 5)
    levels = np.concatenate(
        [
            [0.0],
            np.geomspace(weak / 2, min(weak * 4, saturation / 4), 12),
            np.linspace(saturation / 30, saturation * 0.92, 30),
            np.linspace(saturation * 0.93, saturation * 1.05, 10),
            [saturation * 1.5, saturation * 2],
        ]
    )
    noisy = dark.variance_dn2 >= 2 * rounding.LEAST_VARIANCE_DN2 and dark.zero_fraction == 0
    bias = 0.0 if noisy else max(2 * weak, lifted)
    return Plan(
        bit_depth=bit_depth,
        exposure_s=exposure_s,
        photons=tuple(float(x) for x in np.sort(levels)),
        frames=frames,
        flat_photons=(0.0, float(lifted), float(saturation / 2)),
        flat_frames=flat_frames,
        dark_exposures_s=_dark_exposures(probe, bias, exposure_s, longest_exposure_s, rise),
        dark_photons=float(bias),
        photons_absolute=photons_absolute,
    )


class _Probe(Protocol):
    def __call__(self, photons: float, at_s: float = ...) -> Level: ...


def _rise_dn2(dark: Level, lit: Level) -> float:
    """Give the rise of the temporal variance, or the most that its errors may hide."""
    rise = lit.variance_dn2 - dark.variance_dn2
    error = Z99 * math.hypot(*(lv.variance_dn2 * math.sqrt(2 / lv.freedom) for lv in (dark, lit)))
    return rise if rise > error else rise + error


def _lifted(probe: _Probe, dark: Level, weak: float, most: float) -> float:
    """Find a weak light that lifts the noise off DN 0, where the black level does not."""
    if dark.zero_fraction <= CLIPPED:
        return weak
    while weak < most and probe(weak).zero_fraction > CLIPPED / 2:
        weak *= 1.25
    return min(weak, most)


def _saturation(probe: _Probe, dark: Level) -> tuple[Level, Level]:
    """Find a level at 20 to 60 % of saturation, and one beyond saturation."""
    # Beyond saturation a doubling of the light adds almost nothing.
    photons = 1000.0
    full, doubled = probe(photons), probe(2 * photons)
    for _ in range(40):
        rise = doubled.mean_dn - dark.mean_dn
        if rise > 2 and doubled.mean_dn - full.mean_dn < 0.01 * rise:
            break
        photons *= 2
        full, doubled = doubled, probe(2 * photons)
    else:
        raise InputError(
            f"no saturation up to {photons:.3g} photons on a pixel",
            field="frames",
            remedy="let the light reach the camera",
        )
    low, high = 0.0, full.photons
    for _ in range(60):
        middle = probe((low + high) / 2)
        part = (middle.mean_dn - dark.mean_dn) / (doubled.mean_dn - dark.mean_dn)
        if 0.2 <= part <= 0.6:
            return middle, doubled
        low, high = (middle.photons, high) if part < 0.2 else (low, middle.photons)
    raise InputError(
        "the response jumps from dark to saturated",
        field="frames",
        remedy="give raw frames of one channel under a steady light",
    )


def _dark_exposures(
    probe: _Probe, photons: float, shortest_s: float, longest_s: float, range_dn: float
) -> tuple[float, ...]:
    start, end = probe(photons, shortest_s), shortest_s
    while end < longest_s:
        end = min(2 * end, longest_s)
        if probe(photons, end).mean_dn - start.mean_dn > range_dn / 10:
            break
    return tuple(float(x) for x in np.linspace(shortest_s, end, 6))
