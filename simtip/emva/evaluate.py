"""From tables of levels and a few mean frames to the parameters of the camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simtip.emva import rounding
from simtip.emva.estimate import Estimate
from simtip.emva.frames import Level, MeanFrame
from simtip.emva.result import CameraCharacteristics
from simtip.emva.spatial import Pattern, fit_pattern
from simtip.emva.transfer import CLIPPED, Spread, Transfer, fit_transfer
from simtip.errors import InputError

FLAT = 0.005
"""Two levels beyond saturation that differ by less than this part of the range are a plateau."""


@dataclass(frozen=True)
class Series:
    """What was measured of one channel.

    Attributes
    ----------
    transfer
        Levels of one exposure time, one of them dark, the brightest two well beyond saturation.
    dark
        Levels of equal photons (0, or a weak constant light) and several exposure times.
    flats
        Mean frames at the exposure time of `transfer`: dark, half-lit and, for a camera whose
        dark noise is below the rounding, weakly lit.
    """

    transfer: tuple[Level, ...]
    dark: tuple[Level, ...] = ()
    flats: tuple[MeanFrame, ...] = ()


def characterise(
    series: Series, *, bit_depth: int, photons_absolute: bool = True
) -> CameraCharacteristics:
    """Find the EMVA 1288 parameters, each with a 99 % confidence interval.

    - ``K_dn_per_e``: slope of the temporal variance against the mean, levels up to 70 % of
      saturation, weighted least squares; rounding's 1/12 DN^2 is taken off every variance.
    - ``sigma_d_e``: root of that line's intercept, over K. Dark electrons count as signal, so it
      is the noise without exposure. A dark level that is resolved (0.24 DN^2, the standard's
      limit) dominates it; else the lit levels do, where the standard gives only a bound.
    - ``dark_current_e_per_s``: slope of the mean against exposure time, over K; by variance as a
      check.
    - ``saturation_capacity_e``: the standard's, the signal at the greatest temporal variance.
      A hard clip at W electrons cuts into the noise before the mean reaches it: that variance
      peaks some standard deviations of the signal, among frames and pixels, below W (3 to 5 % at
      10,000 e-). So it is not W.
    - ``full_well_e``: where the mean stops, beyond saturation, over K: W itself if electrons clip
      first; if the top code does, (top code - black level) / K, and the well holds more. It
      counts all electrons of a pixel, dark ones too. ``full_well_limit`` says which.
    - ``snr_max``: ``sqrt(full_well_e)``.
    - ``dsnu_e``, ``prnu_percent``: see `simtip.emva.spatial`.
    - ``quantum_efficiency``: slope of the mean against photons, over K.

    Not corrected: uneven light (it counts as PRNU; the standard's high-pass is left out), a
    curved response, outlying pixels, drift within a series other than between pairs.

    Parameters
    ----------
    series
        What was measured.
    bit_depth
        Bits of the values as stored.
    photons_absolute
        False if the photon numbers are only proportional to the true ones.

    Raises
    ------
    InputError
        No dark level, fewer than four levels, or levels of several exposure times.
    """
    levels = _sorted(series.transfer)
    _check(levels, series)
    transfer = fit_transfer(levels, series.dark, Spread())
    if isinstance(transfer, str):
        return _nothing(levels, transfer)
    pattern = fit_pattern(series.flats, transfer, _capacity_dn(levels, transfer))
    if isinstance(pattern, Pattern):
        # Once more: pixels that differ among each other help against rounding.
        again = fit_transfer(levels, series.dark, Spread(pattern.offset_dn2, pattern.gain))
        transfer = transfer if isinstance(again, str) else again
        pattern = fit_pattern(series.flats, transfer, _capacity_dn(levels, transfer))
    full_well, limit, remarks = _full_well(levels, transfer, pattern, 2**bit_depth - 1)
    prnu, dsnu = _non_uniformity(transfer, pattern)
    return CameraCharacteristics(
        K_dn_per_e=Estimate.of(transfer.line.slope, transfer.line.covariance[1, 1]),
        sigma_d_e=_dark_noise(transfer),
        dark_current_e_per_s=_dark_current(transfer),
        dark_current_by_variance_e_per_s=_dark_current_by_variance(transfer),
        full_well_e=full_well,
        full_well_limit=limit,
        saturation_capacity_e=_saturation_capacity(levels, transfer),
        prnu_percent=prnu,
        dsnu_e=dsnu,
        snr_max=_root(full_well),
        quantum_efficiency=_quantum_efficiency(transfer, pattern, absolute=photons_absolute),
        black_level_dn=Estimate.of(transfer.black_dn, transfer.black_variance),
        photon_transfer=levels,
        in_fit=transfer.in_fit,
        notes=(*_notes(levels, transfer, pattern), *remarks),
    )


def _sorted(levels: Sequence[Level]) -> tuple[Level, ...]:
    return tuple(sorted(levels, key=lambda level: (level.photons, -level.frames)))


def _check(levels: Sequence[Level], series: Series) -> None:
    if len(levels) < 4 or levels[0].photons != 0:
        raise InputError(
            f"{len(levels)} levels, the darkest at {levels[0].photons if levels else 0:g} photons",
            field="transfer",
            remedy="give a dark level (0 photons) and three lit ones at least",
        )
    if len({level.exposure_s for level in (*levels, *(f.level for f in series.flats))}) > 1:
        raise InputError(
            "levels of several exposure times",
            field="transfer",
            remedy="vary the light alone; exposure times belong into the dark series",
        )
    if len({level.photons for level in series.dark}) > 1:
        raise InputError(
            "dark levels of several lights", field="dark", remedy="vary the exposure time alone"
        )


def _capacity_dn(levels: Sequence[Level], transfer: Transfer) -> float:
    top = len(levels) - 1 if transfer.saturation is None else transfer.saturation
    return levels[top].mean_dn - transfer.black_dn - transfer.dark_offset_dn


def _dark_noise(transfer: Transfer) -> Estimate:
    v, K = transfer.line.intercept, transfer.line.slope
    slope = np.array([1 / K**2, -2 * v / K**3])
    return Estimate.root(v / K**2, float(slope @ transfer.line.covariance @ slope))


def _dark_current(transfer: Transfer) -> Estimate:
    if transfer.dark is None:
        return Estimate.missing("fewer than two usable exposure times in the dark series")
    K, rate = transfer.line.slope, transfer.dark.slope / transfer.line.slope
    variance = transfer.dark.covariance[1, 1] + rate**2 * transfer.line.covariance[1, 1]
    return Estimate.of(rate, variance / K**2)


def _dark_current_by_variance(transfer: Transfer) -> Estimate:
    if transfer.dark_variance is None:
        return Estimate.missing("fewer than two usable exposure times in the dark series")
    K, rate = transfer.line.slope, transfer.dark_variance.slope / transfer.line.slope**2
    variance = transfer.dark_variance.covariance[1, 1] / K**4
    return Estimate.of(rate, variance + 4 * rate**2 * transfer.line.covariance[1, 1] / K**2)


def _saturation_capacity(levels: Sequence[Level], transfer: Transfer) -> Estimate:
    index = transfer.saturation
    if index is None:
        return Estimate.missing("no level lies beyond the greatest temporal variance")
    beside = (max(index - 1, 0), index, min(index + 1, len(levels) - 1))
    dark_dn = transfer.black_dn + transfer.dark_offset_dn
    low, value, high = ((levels[i].mean_dn - dark_dn) / transfer.line.slope for i in beside)
    return Estimate(value, low, high)


def _full_well(
    levels: Sequence[Level], transfer: Transfer, pattern: Pattern | str, top_dn: int
) -> tuple[Estimate, Literal["well", "adc"] | None, list[str]]:
    before, last = levels[-2:]
    rise = last.mean_dn - transfer.black_dn
    flat = abs(last.mean_dn - before.mean_dn) <= FLAT * rise
    if transfer.saturation is None or not flat or last.photons < 1.1 * before.photons:
        reason = "the two brightest levels do not show a plateau beyond saturation"
        return Estimate.missing(reason), None, []
    K, remarks = transfer.line.slope, []
    limit: Literal["well", "adc"] = "adc" if last.top_fraction >= 0.5 else "well"
    if limit == "adc":
        plateau, variance = float(top_dn), 0.0
        remarks.append("the top code clips before the well: the well holds more than full_well_e")
    else:
        plateau = last.mean_dn
        spread = pattern.offset_dn2 if isinstance(pattern, Pattern) else 0.0
        noise = transfer.noise_dn2(np.array(0.0))
        variance = float(rounding.mean_error(noise, spread)) ** 2
        variance += last.variance_dn2 / (last.frames * last.pixels)
        if last.top_fraction > CLIPPED:
            remarks.append("read noise reaches the top code at full well: full_well_e is too low")
    value = (plateau - transfer.black_dn) / K
    variance += transfer.black_variance + value**2 * float(transfer.line.covariance[1, 1])
    return Estimate.of(value, variance / K**2), limit, remarks


def _non_uniformity(transfer: Transfer, pattern: Pattern | str) -> tuple[Estimate, Estimate]:
    if isinstance(pattern, str):
        return Estimate.missing(pattern), Estimate.missing(pattern)
    K = transfer.line.slope
    square = pattern.offset_dn2 / K**2
    variance = pattern.offset_variance + 4 * square**2 * K**2 * transfer.line.covariance[1, 1]
    prnu = Estimate.root(pattern.gain, pattern.gain_variance, scale=100)
    return prnu, Estimate.root(square, float(variance) / K**4)


def _quantum_efficiency(transfer: Transfer, pattern: Pattern | str, *, absolute: bool) -> Estimate:
    if not absolute:
        return Estimate.missing("the photon numbers are relative")
    K, eta = transfer.line.slope, transfer.light.slope / transfer.line.slope
    variance = transfer.light.covariance[1, 1] + eta**2 * transfer.line.covariance[1, 1]
    if isinstance(pattern, Pattern):
        # These pixels are a sample: their mean response differs from the process's.
        variance += transfer.light.slope**2 * max(pattern.gain, 0) / pattern.pixels
    return Estimate.of(eta, variance / K**2)


def _root(square: Estimate) -> Estimate:
    if square.value is None or square.low is None or square.high is None:
        return square
    low, value, high = (math.sqrt(max(x, 0)) for x in (square.low, square.value, square.high))
    return Estimate(value, low, high)


def _notes(levels: Sequence[Level], transfer: Transfer, pattern: Pattern | str) -> list[str]:
    notes = []
    if levels[0].zero_fraction > CLIPPED:
        notes.append(
            f"{levels[0].zero_fraction:.1%} of the dark samples are at DN 0: the dark noise is "
            "cut off there, so black level and sigma_d_e come from brighter levels"
        )
    elif not transfer.dark_resolved:
        notes.append(
            "the dark noise is below what whole DN resolve (0.24 DN^2): black level and "
            "sigma_d_e come from brighter levels; the standard would only bound sigma_d_e by "
            f"{0.4 / transfer.line.slope:.3g} e-"
        )
    if isinstance(pattern, Pattern) and pattern.extrapolated:
        notes.append("dsnu_e comes from lit frames, followed to no light pixel by pixel")
    if transfer.saturation is None:
        notes.append("saturation was not reached: 70 % of the brightest level stands in for it")
    if transfer.dark is None:
        notes.append("no dark current was measured: sigma_d_e holds its shot noise too")
    if transfer.line.misfit > 1:
        notes.append("variance against mean is no straight line at the errors expected")
    if transfer.light.misfit > 1:
        notes.append("mean against photons is no straight line at the errors expected")
    return notes


def _nothing(levels: tuple[Level, ...], reason: str) -> CameraCharacteristics:
    none = Estimate.missing(reason)
    return CameraCharacteristics(
        K_dn_per_e=none,
        sigma_d_e=none,
        dark_current_e_per_s=none,
        dark_current_by_variance_e_per_s=none,
        full_well_e=none,
        full_well_limit=None,
        saturation_capacity_e=none,
        prnu_percent=none,
        dsnu_e=none,
        snr_max=none,
        quantum_efficiency=none,
        black_level_dn=none,
        photon_transfer=levels,
        in_fit=(False,) * len(levels),
        notes=(),
    )
