"""How bright a needle's tip and what is behind it are in each pixel: smooth, so of a few modes.

The mean over what a pixel sees of the shaft, or of the tip's own part: along its row, and in a
blurred picture what the lens makes of it.
"""

from __future__ import annotations

import numpy as np

from simtip.detect.subpixel.edge_table import brightness_integral
from simtip.detect.subpixel.picture import LEAST_COVER, Cells, Placed, Window, cell_covers
from simtip.geometry import Array

SHAFT_EVEN, SHAFT_ODD = 7, 6
TIP_EVEN, TIP_ODD = 6, 5
"""Brightness modes, besides the constant and its change along the axis."""

GROUND_COLUMNS = 3
SHAFT_COLUMNS = 2 + SHAFT_EVEN + SHAFT_ODD
TIP_COLUMNS = 3 + TIP_EVEN + TIP_ODD
"""What the brightness of each is made of."""

BLURRED_ROWS = 1
"""Rows of cells to a pixel in which a blurred picture's brightness is worked out: it is smooth."""

PROFILE_STEP_PX = 1 / 10
"""Of the table of the shaft's brightness across."""


def _mean_brightness(low: Array, high: Array, even: int, odd: int) -> Array:
    """Give the means (n, 1 + even + odd) of constant and modes from s = low to high (n,)."""
    wide = np.maximum(high - low, 1e-3)
    middle = (low + high) / 2
    begin, end = middle - wide / 2, middle + wide / 2
    means = brightness_integral(end, even, odd)
    means -= brightness_integral(begin, even, odd)
    reach = np.minimum(end, 1) - np.maximum(begin, -1)
    means /= np.maximum(reach, 1e-6)[:, None]
    return means


def _seen(u: Array, low: Array, high: Array, reach: float) -> tuple[Array, Array]:
    """Give the part of [low, high] within `reach` of u as s from -1 to 1: both ends (n,)."""
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-3)
    # Beyond an edge: what is right at it.
    begin = np.minimum(np.maximum((u - reach - middle) / half, -1), 0.999)
    end = np.maximum(np.minimum((u + reach - middle) / half, 1), -0.999)
    return begin, end


def ground_columns(window: Window) -> Array:
    """Give what the background's brightness is made of (H W, 3): constant, change by u and v."""
    v, u = np.divmod(np.arange(window.height * window.width), window.width)
    return np.column_stack([np.ones(len(u)), u / window.width - 0.5, v / window.height - 0.5])


def blurred_columns(placed: Placed, cells: Cells) -> Array:
    """Give what the brightness of shaft and tip is made of in blurred pixels.

    Each is that of what is seen of it: blurred in all, over its blurred cover.

    Parameters
    ----------
    placed
        The outline.
    cells
        Of the window, `BLURRED_ROWS` to a pixel.

    Returns
    -------
    columns
        (H W, `SHAFT_COLUMNS` + `TIP_COLUMNS`), 0 where none is seen.
    """
    whole, tip = cell_covers(placed, cells)
    u, v = (each.reshape(-1) for each in np.meshgrid(cells.columns, cells.rows))
    sides = np.repeat(placed.intervals(cells.rows), len(cells.columns), axis=1)
    found = []
    for cover, columns_of, count in (
        (whole if tip is None else whole - tip, shaft_columns, SHAFT_COLUMNS),
        (tip, tip_columns, TIP_COLUMNS),
    ):
        if cover is None:
            found.append(np.zeros((len(cells.none), count)))
            continue
        share = cover.reshape(-1)
        (there,) = np.nonzero(share > LEAST_COVER)
        parts = np.zeros((len(share), count + 1), np.float32)
        parts[:, count] = share
        bare = columns_of(placed, u[there], v[there], sides[:, there], 0.5 / cells.fine)
        parts[there, :count] = bare * share[there, None]
        seen = cells.pixels(parts.reshape(*cover.shape, count + 1))
        found.append(seen[:, :count] / np.maximum(seen[:, count:], LEAST_COVER))
    return np.concatenate(found, axis=1)


def shaft_columns(placed: Placed, u: Array, v: Array, sides: Array, reach: float) -> Array:
    """Give what the shaft's brightness is made of at points (n,): (n, `SHAFT_COLUMNS`).

    It is the mean over `reach` px to either side in a point's row.

    Of a pixel at a cut's edge, what is cut away does not count: there the shaft may be brighter.
    `sides` are `Placed.sides_of` the pixels.
    """
    half = placed.half_px
    least = PROFILE_STEP_PX / half
    low, high = (placed.x_at(side, v) / half for side in _beside_facet(placed, u, sides))
    s, reach = placed.x_at(u, v) / half, reach / half
    # Beyond an edge: what is right at it.
    begin = np.maximum(np.minimum(np.maximum(s - reach, low), high - least), -1)
    end = np.minimum(np.maximum(np.minimum(s + reach, high), begin + least), 1)
    columns = np.empty((len(u), SHAFT_COLUMNS))
    profile = _Profile(half)
    across = columns[:, :-1]
    np.subtract(profile.integral(end), profile.integral(begin), out=across)
    across /= (end - begin)[:, None]
    columns[:, -1] = _change(placed, u, v)
    return columns


def _beside_facet(placed: Placed, u: Array, sides: Array) -> tuple[Array, Array]:
    """Give left and right u (n,) of what in a pixel's row is shaft, on its side of a facet."""
    left, right, low, high, there = sides
    if placed.facet is None or not len(placed.facet):
        return left, right
    facet = (there > 0) & (high > low)
    at_left = u < (low + high) / 2
    return np.where(facet & ~at_left, high, left), np.where(facet & at_left, low, right)


class _Profile:
    """The integrals of the shaft's modes across it: a table, in between it is linear."""

    def __init__(self, half_px: float) -> None:
        self._steps = int(np.ceil(2 * half_px / PROFILE_STEP_PX))
        nodes = np.linspace(-1, 1, self._steps + 1)
        self._at = brightness_integral(nodes, SHAFT_EVEN, SHAFT_ODD)
        self._slope = np.diff(self._at, axis=0)

    def integral(self, s: Array) -> Array:
        """Give them from -1 to s = x / half width (n,), within -1 to 1: (n, modes)."""
        place = (s + 1) * (self._steps / 2)
        k = np.minimum(place.astype(np.intp), self._steps - 1)
        found = self._slope[k]
        found *= (place - k)[:, None]
        found += self._at[k]
        return found


def tip_columns(placed: Placed, u: Array, v: Array, sides: Array, reach: float) -> Array:
    """Give what the tip's own brightness is made of at points (n,), as `shaft_columns` does."""
    low, high = sides[2:4]
    s = (u - (low + high) / 2) / np.maximum((high - low) / 2, 0.5)
    change = _change(placed, u, v)
    across = _mean_brightness(*_seen(u, low, high, reach), TIP_EVEN, TIP_ODD)
    slant = np.minimum(np.maximum(s, -1), 1) * change
    return np.concatenate([across, change[:, None], slant[:, None]], axis=1)


def _change(placed: Placed, u: Array, v: Array) -> Array:
    """Give how far up the needle pixels lie, in depths of its tip, up to two."""
    z = placed.z_at(u, v) / max(placed.depth_px, 1.0)
    return np.asarray(np.minimum(np.maximum(z, 0), 2) - 0.5)
