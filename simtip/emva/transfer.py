"""The photon transfer: temporal variance against mean, and what their line says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.emva import rounding
from simtip.emva.estimate import Z99, Array, Line, fit_line
from simtip.emva.frames import Level

CLIPPED = 1e-3
"""Share of samples at DN 0 above which a level is left out.

Normal noise cut off at 3.1 sigma (a share of 1e-3) loses 0.2 % of its variance.
"""

RANGE = 0.7
"""Part of the saturation that the line is fitted to (EMVA 1288)."""

_ROUNDS = 10  # of weights from the last fit; three are enough in practice


@dataclass(frozen=True)
class Spread:
    """Spatial variance that rounding sees: ``offset + gain x^2`` at the signal x, DN^2."""

    offset_dn2: float = 0.0
    gain: float = 0.0

    def at(self, signal_dn: Array) -> Array:
        """Give it at the signal, DN above black."""
        spread: Array = self.offset_dn2 + self.gain * signal_dn**2
        return spread


@dataclass(frozen=True)
class Transfer:
    """The fitted photon transfer; DN throughout.

    Attributes
    ----------
    line
        Variance without rounding against signal: intercept (K sigma_d)^2, slope K.
    light
        Mean against photons, at the one exposure of the levels.
    dark
        Mean against exposure time, or None.
    dark_variance
        Variance without rounding against exposure time, or None.
    black_dn, black_variance
        Mean without light and exposure, and the variance of that estimate.
    dark_offset_dn
        What the dark signal of the levels' exposure adds to the black level.
    in_fit
        Which levels the line was fitted to.
    dark_resolved
        The dark level is neither clipped nor too quiet for rounding.
    saturation
        Index of the level of greatest variance, or None if no level lies beyond it.
    """

    line: Line
    light: Line
    dark: Line | None
    dark_variance: Line | None
    black_dn: float
    black_variance: float
    dark_offset_dn: float
    in_fit: tuple[bool, ...]
    dark_resolved: bool
    saturation: int | None

    def noise_dn2(self, signal_dn: Array) -> Array:
        """Give the temporal variance without rounding at the signal, DN above black."""
        noise: Array = np.maximum(self.line.intercept + self.line.slope * signal_dn, 0)
        return noise


class _Columns:
    """Levels as arrays (n,)."""

    def __init__(self, levels: Sequence[Level]) -> None:
        self.photons = np.array([level.photons for level in levels])
        self.exposure = np.array([level.exposure_s for level in levels])
        self.mean = np.array([level.mean_dn for level in levels])
        self.variance = np.array([level.variance_dn2 for level in levels])
        self.freedom = np.array([float(level.freedom) for level in levels])
        self.samples = np.array([float(level.frames * level.pixels) for level in levels])
        self.unclipped = np.array([level.zero_fraction <= CLIPPED for level in levels], dtype=bool)

    def mean_error(self, noise: Array, spread: Array) -> Array:
        """Variance of each mean: noise left after averaging, and rounding's ripple."""
        ripple = rounding.mean_error(noise, spread)
        error: Array = (noise + rounding.ROUNDING_DN2) / self.samples + ripple**2
        return error

    def variance_error(self, noise: Array, shot: Array, gain: float, spread: Array) -> Array:
        """Variance of each variance.

        ``2 V^2 / n`` for normal noise; the difference of two Poisson numbers has a fourth
        cumulant on top, K^3 times the shot signal here, of which a pair shows half.
        """
        total = noise + rounding.ROUNDING_DN2
        fourth = gain**3 * np.maximum(shot, 0) / 2
        ripple = rounding.variance_error(noise, spread)
        error: Array = (2 * total**2 + fourth) / self.freedom + ripple**2
        return error


def saturation_index(levels: Sequence[Level]) -> int | None:
    """Find the level of greatest variance; None if the variance never falls clearly after it."""
    variance = np.array([level.variance_dn2 for level in levels])
    top = int(np.argmax(variance))
    return top if (variance[top:] < 0.8 * variance[top]).any() else None


def fit_transfer(
    levels: Sequence[Level], dark_levels: Sequence[Level], spread: Spread
) -> Transfer | str:
    """Fit the photon transfer, weights and black level being found by iteration.

    The line goes through all unclipped levels up to 70 % of saturation. Each variance is weighted
    by the variance that it has as an estimate, plus the square of what rounding may do to it: so
    a dark level too quiet to be resolved drops out by itself, and its variance and black level
    are those at which the lines through the brighter levels arrive. Dark electrons count as
    signal, so the intercept is the noise of the read-out alone.

    Parameters
    ----------
    levels
        By rising photons, of one exposure time, the first dark.
    dark_levels
        Equal photons (0, or a constant weak light), several exposure times; may be empty.
    spread
        Spatial variances, if known.

    Returns
    -------
    transfer
        Or why there is none.
    """
    rows, dark_rows = _Columns(levels), _Columns(dark_levels)
    peak = saturation_index(levels)
    black = float(rows.mean[0])
    ceiling = black + RANGE * (float(rows.mean[-1 if peak is None else peak]) - black)
    below = rows.unclipped & (rows.mean <= ceiling)
    if peak is not None:
        below &= np.arange(len(levels)) <= peak
    start = below & (rows.variance >= 2 * rounding.LEAST_VARIANCE_DN2) & (rows.photons > 0)
    if start.sum() < 3:
        return (
            f"fewer than three levels below {RANGE:.0%} of saturation have enough noise "
            f"(0.48 DN^2) to be measured in whole DN"
        )
    gain = float(np.median(rows.variance[start] / np.maximum(rows.mean[start] - black, 0.1)))
    fit = _Fit(rows, dark_rows, below, (dark_rows.mean <= ceiling) & dark_rows.unclipped, spread)
    fit.begin(gain, black)
    for _ in range(_ROUNDS):
        fit.improve()
    if fit.line.slope <= Z99 * math.sqrt(fit.line.covariance[1, 1]):
        return "the temporal variance does not rise with the signal: there is no shot noise to see"
    return fit.transfer(peak)


class _Fit:
    """The state of the iteration in `fit_transfer`."""

    def __init__(
        self,
        rows: _Columns,
        dark_rows: _Columns,
        below: NDArray[np.bool_],
        dark_usable: NDArray[np.bool_],
        spread: Spread,
    ) -> None:
        self.rows, self.dark_rows, self.spread = rows, dark_rows, spread
        self.below, self.dark_usable = below, dark_usable
        self.exposure_s = float(rows.exposure[0])
        self.dark: Line | None = None
        self.dark_variance: Line | None = None

    def begin(self, gain: float, black: float) -> None:
        self.line = Line(0.0, gain, np.zeros((2, 2)), 0.0)
        self.black, self.black_variance, self.dark_offset = black, 0.0, 0.0

    def improve(self) -> None:
        rows, below = self.rows, self.below
        noise, spread = self._expected(rows)
        self._improve_dark()
        error = rows.mean_error(noise, spread)
        self.light = fit_line(rows.photons[below], rows.mean[below], error[below])
        dark_total = noise[0] + spread[0] + rounding.ROUNDING_DN2
        self.resolved = bool(below[0] and dark_total >= rounding.LEAST_VARIANCE_DN2)
        if self.resolved:
            with_dark, variance = float(rows.mean[0]), float(error[0])
        else:
            with_dark, variance = self.light.intercept, float(self.light.covariance[0, 0])
        if self.dark is not None:
            self.dark_offset = self.dark.slope * self.exposure_s
            variance += float(self.dark.covariance[1, 1]) * self.exposure_s**2
        self.black, self.black_variance = with_dark - self.dark_offset, variance
        self._improve_line(noise, spread)

    def _improve_line(self, noise: Array, spread: Array) -> None:
        rows, below = self.rows, self.below
        signal = rows.mean - self.black
        error = rows.variance_error(noise, signal, self.line.slope, spread)
        net = rows.variance - rounding.ROUNDING_DN2
        line = fit_line(signal[below], net[below], error[below])
        covariance = line.covariance.copy()
        # A black level too high by d moves every signal by -d, the intercept by K d.
        covariance[0, 0] += line.slope**2 * self.black_variance
        self.line = Line(line.intercept, line.slope, covariance, line.misfit)

    def _improve_dark(self) -> None:
        rows, usable = self.dark_rows, self.dark_usable
        if len(np.unique(rows.exposure[usable])) < 2:
            self.dark = self.dark_variance = None
            return
        noise, spread = self._expected(rows)
        quiet = rounding.mean_error(noise, spread) > 0.01
        clear = usable & ~quiet
        # Quiet levels may all err alike, stuck on one code: use them only if there is no other.
        use = clear if len(np.unique(rows.exposure[clear])) >= 2 else usable
        error = rows.mean_error(noise, spread)
        self.dark = fit_line(rows.exposure[use], rows.mean[use], error[use])
        shot = rows.mean - self.black
        error = rows.variance_error(noise, shot, self.line.slope, spread)
        net = rows.variance - rounding.ROUNDING_DN2
        self.dark_variance = fit_line(rows.exposure[use], net[use], error[use])

    def _expected(self, rows: _Columns) -> tuple[Array, Array]:
        signal = np.maximum(rows.mean - self.black, 0)
        noise = np.maximum(self.line.intercept, 0) + np.maximum(self.line.slope, 1e-9) * signal
        return noise, self.spread.at(signal)

    def transfer(self, peak: int | None) -> Transfer:
        return Transfer(
            line=self.line,
            light=self.light,
            dark=self.dark,
            dark_variance=self.dark_variance,
            black_dn=self.black,
            black_variance=self.black_variance,
            dark_offset_dn=self.dark_offset,
            in_fit=tuple(bool(used) for used in self.below),
            dark_resolved=self.resolved,
            saturation=peak,
        )
