"""Differences between pixels: DSNU and PRNU from mean frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simtip.emva import rounding
from simtip.emva.frames import MeanFrame
from simtip.emva.transfer import CLIPPED, Transfer


@dataclass(frozen=True)
class Pattern:
    """The camera's fixed pattern.

    Attributes
    ----------
    offset_dn2
        Spatial variance without light, DN^2: (K DSNU)^2.
    gain
        Relative spatial variance of the response: PRNU^2.
    offset_variance, gain_variance
        Variances of these two estimates.
    pixels
        How many pixels were compared.
    extrapolated
        The offsets come from lit frames, pixel by pixel, as the dark ones are not resolved.
    """

    offset_dn2: float
    gain: float
    offset_variance: float
    gain_variance: float
    pixels: int
    extrapolated: bool


def fit_pattern(
    frames: Sequence[MeanFrame], transfer: Transfer, capacity_dn: float
) -> Pattern | str:
    """Separate offsets from responses, by a dark (or weakly lit) and a half-lit mean frame.

    With a resolved dark frame this is EMVA 1288: ``s_dark^2`` and ``(s_50^2 - s_dark^2) / x^2``
    from spatial variances less the temporal noise left in the mean frames, x being the signal.
    Otherwise each pixel's line through a weakly lit and the half-lit frame is followed to no
    light, which takes the response differences out, and the variance is taken there.

    The intervals hold the variance of the process that made the pattern, of which these pixels
    are a sample; both patterns are taken as normal, without outliers.

    Parameters
    ----------
    frames
        Mean frames at the exposure time of the photon transfer.
    transfer
        The photon transfer of the same camera.
    capacity_dn
        Saturation above black, DN.
    """
    dark_dn = transfer.black_dn + transfer.dark_offset_dn
    bright = _bright(frames, dark_dn, capacity_dn)
    if bright is None:
        return "no mean frame lies at 30 to 70 % of saturation"
    base = _base(frames, transfer, dark_dn, bright)
    if base is None:
        return (
            "no mean frame up to a quarter of saturation is clear of DN 0 and noisy enough for "
            "whole DN (0.24 DN^2): raise the black level, or add a weakly lit mean frame"
        )
    dark = base.level.photons == 0
    x1 = 0.0 if dark else base.level.mean_dn - dark_dn
    x2 = bright.level.mean_dn - (base.level.mean_dn if dark else dark_dn)
    far, near = x2 / (x2 - x1), x1 / (x2 - x1)

    offset_noise = far**2 * base.residual_dn2 + near**2 * bright.residual_dn2
    offset_total = float(np.var(far * base.mean_dn - near * bright.mean_dn, ddof=1))
    offset = offset_total - offset_noise
    bright_total = float(np.var(bright.mean_dn, ddof=1))
    gain = (bright_total - bright.residual_dn2 - offset) / x2**2

    freedom = base.level.pixels - 1
    quiet = float(transfer.noise_dn2(np.array(base.level.mean_dn - transfer.black_dn)))
    base_pattern = max(float(np.var(base.mean_dn, ddof=1)) - base.residual_dn2, 0)
    offset_variance = (
        2 * offset_total**2 / freedom
        + far**4 * _residual_variance(base)
        + near**4 * _residual_variance(bright)
        + (far**2 * rounding.spatial_error(quiet, base_pattern)) ** 2
    )
    shared = max(offset, 0) - near * bright.residual_dn2
    bright_variance = 2 * bright_total**2 / freedom + _residual_variance(bright)
    gain_variance = (bright_variance + offset_variance - 4 * shared**2 / freedom) / x2**4
    return Pattern(offset, gain, offset_variance, gain_variance, base.level.pixels, not dark)


def _residual_variance(frame: MeanFrame) -> float:
    """Give the variance of `residual_dn2` as an estimate, DN^4."""
    return 2 * frame.residual_dn2**2 / (frame.level.pixels * (frame.level.frames - 1))


def _bright(frames: Sequence[MeanFrame], dark_dn: float, capacity_dn: float) -> MeanFrame | None:
    def off(frame: MeanFrame) -> float:
        return abs((frame.level.mean_dn - dark_dn) / capacity_dn - 0.5)

    return min((frame for frame in frames if off(frame) <= 0.2), key=off, default=None)


def _base(
    frames: Sequence[MeanFrame], transfer: Transfer, dark_dn: float, bright: MeanFrame
) -> MeanFrame | None:
    """Find the darkest mean frame that can be used."""
    signal = bright.level.mean_dn - dark_dn
    for frame in sorted(frames, key=lambda frame: frame.level.photons):
        level = frame.level
        if level.zero_fraction > CLIPPED or level.mean_dn - dark_dn > signal / 2:
            continue
        if level.photons == 0:
            if transfer.dark_resolved:
                return frame
            continue
        noise = transfer.noise_dn2(np.array(level.mean_dn - transfer.black_dn))
        if noise + rounding.ROUNDING_DN2 >= rounding.LEAST_VARIANCE_DN2:
            return frame
    return None
