"""How noisy a picture is, from its own pixels beside a needle and within it.

Second differences along the needle, in which all that is smooth cancels. Not at its edges: on a
slant even the smoothest edge is no straight line along any row of pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array

CLEAR_PX = 2.5
"""From an edge, and two deviations of the blur more."""

BESIDE_PX = 8
"""How far beyond that the ground is looked at."""

KEPT = 0.9
"""Of the squared differences, those that count: dirt and other needles are among the others."""

KEPT_MEAN = 0.623
"""Mean of the smallest `KEPT` of squared normal numbers of variance 1."""

LEAST_PIXELS = 50

LEAST_NOISE_DN2 = 1 / 12
"""Rounding alone (EMVA 1288)."""


def noise_of(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Array:
    """Give the noise's variance, DN^2, as a polynomial (3,) of the level, constant first.

    Parameters
    ----------
    image
        Gray values, turned so that the needle hangs.
    rows
        Consecutive rows that show it.
    shaft
        Good to a pixel.
    """
    v = rows.astype(np.float64)
    half = float(shaft.half_px(v).max())
    spread = 2 * float(np.sqrt(shaft.variance.max()))
    reach = int(np.ceil((half + CLEAR_PX + spread) * 1.5)) + BESIDE_PX
    offset = np.arange(-reach, reach + 1)
    tilt = np.hypot(1, shaft.slope(v))[:, None]
    # The same whole columns in all three rows of a difference: only the ground's slope is left,
    # which cancels.
    centre = shaft.axis_u(v)
    columns = np.rint(centre).astype(np.intp)[1:-1, None] + offset
    inside = (columns > 0) & (columns < image.shape[1] - 1)
    columns = np.clip(columns, 0, image.shape[1] - 1)
    above, at, below = (
        image[rows[k : len(rows) - 2 + k, None], columns].astype(np.float64) for k in range(3)
    )
    away = np.abs(columns - centre[1:-1, None]) / tilt[1:-1]
    # Within a shaft that leans, brightness runs across the rows: there columns follow the axis.
    ground = (
        inside & (away > half + CLEAR_PX + spread) & (away < half + CLEAR_PX + spread + BESIDE_PX)
    )
    dark = inside & (away < half - CLEAR_PX - spread)
    difference = (above - 2 * at + below) ** 2 / 6
    level = (above + at + below) / 3
    told = np.isfinite(level)
    beside, beside_level = _spread(difference, level, ground & told)
    within, within_level = _spread(difference, level, dark & told)
    if beside is None or beside_level is None:
        return np.array([max(within or 0.0, LEAST_NOISE_DN2), 0.0, 0.0])
    if within is None or within_level is None or within > beside:
        return np.array([max(beside, LEAST_NOISE_DN2), 0.0, 0.0])
    return _through((within_level, within), (beside_level, beside))


def _through(dark: tuple[float, float], bright: tuple[float, float]) -> Array:
    """Give the polynomial (3,) through two levels' variances: a line from rounding up, or a bend.

    Light's own noise grows with the level, that of uneven pixels with its square (EMVA 1288).
    """
    (low, dark_dn2), (high, bright_dn2) = dark, bright
    apart = high - low
    slope = max((bright_dn2 - dark_dn2) / apart, 0.0) if apart > 1 else 0.0
    constant = dark_dn2 - slope * low
    if constant >= LEAST_NOISE_DN2:
        return np.array([constant, slope, 0.0])
    if bright_dn2 <= LEAST_NOISE_DN2:
        return np.array([LEAST_NOISE_DN2, 0.0, 0.0])
    # From rounding up, both over their level: a line, too.
    by_dark = max(dark_dn2 - LEAST_NOISE_DN2, 0.0) / max(low, 1.0)
    by_bright = (bright_dn2 - LEAST_NOISE_DN2) / high
    square = min((by_bright - by_dark) / apart, by_bright / high)
    return np.array([LEAST_NOISE_DN2, by_bright - square * high, square])


def _spread(
    difference: Array, level: Array, which: NDArray[np.bool_]
) -> tuple[float | None, float | None]:
    """Give variance and level of some pixels; None of too few."""
    if which.sum() < LEAST_PIXELS:
        return None, None
    squares = np.sort(difference[which])
    kept = squares[: max(1, int(KEPT * len(squares)))]
    return float(kept.mean()) / KEPT_MEAN, float(np.median(level[which]))
