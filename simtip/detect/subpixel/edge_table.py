"""What a camera makes of a straight round needle: profiles across it, as tables over the distance.

Across a long straight needle the picture depends on the distance x from its axis only. Inside, a
round needle's brightness is a smooth function of the angle of its surface, whatever the light.
Outside is the background. The lens blurs it and pixels average it; both are symmetric, so neither
moves an edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.detect.subpixel.blur import transfer, transfer_by_share
from simtip.geometry import Array

STEP_PX = 1 / 16
"""Of the tables."""

LENGTH_RAD = 0.2
"""Over which the brightness changes with the surface's angle: what roughness leaves of its
surroundings."""

EVEN_ALIKE_RAD, ODD_ALIKE_RAD = 0.8, 0.3
"""So far from the edges the brightness is much the same: there the needle mirrors what is behind
it, whatever the light. Both edges together: in a blurred picture a rim looks like more or less
width. How they differ looks like nothing else, and light from one side reaches
far."""

EVEN_MODES, ODD_MODES = 8, 8
"""Of the brightness, the constant not counted."""

INSIDE = 1 + EVEN_MODES + ODD_MODES
"""Columns of the brightness: constant, even modes, odd modes."""

OUTSIDE = 3
"""Further columns: the background at the left, at the right, and its slope."""

_ANGLE_STEPS = 1024


@lru_cache(maxsize=1)
def modes() -> tuple[Array, Array]:
    """Give theta (n,) from -90 to 90 degrees, rad, and the brightness modes there (n, INSIDE).

    A constant, and a Gaussian process with a squared-exponential covariance of unit variance over
    the angle to the nearer edge, faded out towards the edges; alike on both sides (even), and with
    opposite signs (odd). The modes are its eigenfunctions, scaled so that their coefficients have
    unit variance.
    """
    w = (np.arange(90) + 0.5) / 90 * np.pi / 2
    kernel = np.exp(-0.5 * ((w[:, None] - w) / LENGTH_RAD) ** 2)
    theta = (np.arange(_ANGLE_STEPS) + 0.5) / _ANGLE_STEPS * np.pi - np.pi / 2
    away = np.pi / 2 - np.abs(theta)
    sides = []
    for count, alike in ((EVEN_MODES, EVEN_ALIKE_RAD), (ODD_MODES, ODD_ALIKE_RAD)):
        fade = 1 - np.exp(-0.5 * (w / alike) ** 2)
        values, vectors = np.linalg.eigh(fade[:, None] * kernel * fade)
        best = vectors[:, ::-1][:, :count] * np.sqrt(values[::-1][:count])
        sides.append(np.column_stack([np.interp(away, w, column) for column in best.T]))
    even, odd = sides
    odd = odd * np.sign(theta)[:, None]
    return theta, np.column_stack([np.ones(len(theta)), even, odd])


@lru_cache(maxsize=4)
def _integrals(even: int, odd: int) -> tuple[Array, Array, Array]:
    """Give s from -1 to 1, the integral over s from -1 of each mode there, and the modes beyond.

    Shapes (n,), (n, 1 + even + odd), (n - 1, 1 + even + odd).
    """
    edges = np.linspace(-np.pi / 2, np.pi / 2, _ANGLE_STEPS + 1)
    s = np.sin(edges)
    first = 1 + EVEN_MODES
    kept = [*range(1 + even), *range(first, first + odd)]
    mode = np.ascontiguousarray(modes()[1][:, kept])
    sums = np.cumsum(mode * np.diff(s)[:, None], axis=0)
    return s, np.concatenate([np.zeros((1, len(kept))), sums]), mode


def brightness_integral(s: Array, even: int = EVEN_MODES, odd: int = ODD_MODES) -> Array:
    """Give the integral from -1 to s = x / half width of constant, even and odd modes.

    Parameters
    ----------
    s
        (n,).
    even, odd
        How many modes.

    Returns
    -------
    integral
        (n, 1 + even + odd).
    """
    grid, sums, mode = _integrals(even, odd)
    s = np.minimum(np.maximum(s, -1), 1)
    place = (np.arcsin(s) / np.pi + 0.5) * _ANGLE_STEPS
    k = np.minimum(place.astype(np.intp), _ANGLE_STEPS - 1)
    found = mode[k]
    found *= (s - grid[k])[:, None]
    found += sums[k]
    return found


@dataclass(frozen=True, eq=False)
class EdgeTables:
    """Profiles of a needle of given width under some blurs, and how they change.

    Columns (INSIDE + OUTSIDE): the brightness within, and the background.

    Attributes
    ----------
    start_px
        Distance x of the first entry; further ones follow by `STEP_PX`.
    tables
        (blurs, n, 3 or 4, INSIDE + OUTSIDE) profile; its derivatives by x, by the blur's variance
        and, if it is asked for, by the square of the disc's share of it.
    """

    start_px: float
    tables: NDArray[np.float32]

    @classmethod
    def build(
        cls,
        half_px: float,
        reach_px: float,
        slope: Array,
        variance_px2: Array,
        disc_share: float = 0.0,
        *,
        by_share: bool = False,
    ) -> EdgeTables:
        """Build them for distances up to `reach_px` from the axis.

        Parameters
        ----------
        half_px
            Half width of the needle.
        reach_px
            Of the tables to either side.
        slope
            (blurs,) du/dv of the axis: a pixel's square spreads by its projection across the axis.
        variance_px2, disc_share
            Of the lens's blur, (blurs,) and for all, see `simtip.detect.subpixel.blur.transfer`.
        by_share
            Whether the derivative by the share is asked for.
        """
        pad = 4 + 5 * np.sqrt(variance_px2.max())
        count = int(2 ** np.ceil(np.log2(2 * (reach_px + pad) / STEP_PX)))
        x = np.asarray((np.arange(count) - count / 2) * STEP_PX, np.float64)
        cosine, sine = np.array([np.ones_like(slope), abs(slope)]) / np.hypot(1, slope)
        f = scipy.fft.rfftfreq(count, STEP_PX)
        pixel = np.sinc(cosine[:, None] * f) * np.sinc(sine[:, None] * f) / np.sinc(STEP_PX * f)
        lens, by_variance = transfer(f, variance_px2[:, None], disc_share)
        seen = pixel * lens
        kinds = [seen, 2j * np.pi * f * seen, pixel * by_variance]
        if by_share:
            kinds.append(pixel * transfer_by_share(f, variance_px2[:, None], disc_share))
        shapes = np.stack(kinds, axis=1)
        # In single precision: a part in ten million.
        spectrum = scipy.fft.rfft(_cells(x, half_px).astype(np.float32))
        middle, reach = count // 2, int(np.ceil(reach_px / STEP_PX)) + 1
        tables = scipy.fft.irfft(shapes.astype(np.complex64)[:, :, None] * spectrum, count)
        kept = tables[..., middle - reach : middle + reach + 1]
        return cls(float(x[middle - reach]), np.ascontiguousarray(kept.transpose(0, 3, 1, 2)))

    def at(self, x: Array, blur: int = 0) -> Array:
        """Interpolate all tables of a blur at distances (m,): (m, 3 or 4, INSIDE + OUTSIDE)."""
        table = self.tables[blur]
        place = (x - self.start_px) / STEP_PX
        k = np.minimum(np.maximum(place.astype(np.intp), 0), len(table) - 2)
        low, high = table[k], table[k + 1]
        high -= low
        return np.asarray(low + (place - k)[:, None, None] * high)


def _cells(x: Array, half: float) -> Array:
    """Give each column's mean over cells of the table: (INSIDE + OUTSIDE, n)."""
    edges = np.append(x - STEP_PX / 2, x[-1] + STEP_PX / 2)
    columns = np.zeros((INSIDE + OUTSIDE, len(x)))
    # Brightness ends at the needle's edges.
    first, last = np.searchsorted(edges, [-half, half])
    within = slice(max(first - 1, 0), last + 1)
    inside = np.diff(brightness_integral(edges[within] / half), axis=0) * (half / STEP_PX)
    columns[:INSIDE, within.start : within.start + len(inside)] = inside.T
    columns[INSIDE] = -np.diff(np.maximum(-half - edges, 0)) / STEP_PX
    columns[INSIDE + 1] = np.diff(np.maximum(edges - half, 0)) / STEP_PX
    columns[INSIDE + 2] = (columns[INSIDE] + columns[INSIDE + 1]) * x / half
    return columns
