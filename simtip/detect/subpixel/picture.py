"""What a camera makes of a needle's tip: how much of each pixel an outline covers.

Rows finer than pixels are covered exactly along the row, then blurred and averaged. The brightness
within is smooth, so it is worked out at the pixels' middles.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from simtip.detect.subpixel.edge_table import EVEN_MODES, brightness_integral
from simtip.geometry import Array

ROWS, COLUMNS = 4, 2
"""Cells to a pixel."""

SHAFT_EVEN, SHAFT_ODD = 7, 6
TIP_EVEN, TIP_ODD = 6, 5
"""Brightness modes, besides the constant and its change along the axis."""


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels of the turned image: first column and row, and how many."""

    u: int
    v: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Placed:
    """An outline in the image.

    Attributes
    ----------
    corners
        (m, 2) u, v of the convex polygon, from the hub's left end round the tip to its right end.
    facet
        (k, 2) u, v of the outline of what is lit in its own way; None: all up to the depth is.
    origin
        (2,) u, v of the axis at the foremost point's z.
    hub
        (2,) unit vector along the axis towards the hub.
    half_px, depth_px
        Half width of the shaft, and z at which it begins.
    """

    corners: Array
    facet: Array | None
    origin: Array
    hub: Array
    half_px: float
    depth_px: float

    def interval(self, v: Array) -> tuple[Array, Array]:
        """Give left and right u (n,) of the outline at rows v; equal below its end."""
        return _interval(self.corners, v)

    def tip_interval(self, v: Array) -> tuple[Array, Array, Array]:
        """Give left and right u (n,) of the tip's own part, and how much of the row is in it."""
        left, right = self.interval(v)
        if self.facet is None:
            z = self.z_at((left + right) / 2, v)
            return left, right, np.clip((self.depth_px - z) * ROWS + 0.5, 0, 1)
        if len(self.facet) == 0:
            return left, left, np.zeros(len(v))
        k = int(np.argmin(self.facet[:, 1]))
        low, high = _interval(np.roll(self.facet, -k, axis=0), v)
        there = (v >= self.facet[k, 1]).astype(np.float64)
        return np.clip(low, left, right), np.clip(high, left, right), there

    def z_at(self, u: Array, v: Array) -> Array:
        """Give z along the axis of points (n,)."""
        off_u, off_v = u - self.origin[0], v - self.origin[1]
        return np.asarray(off_u * self.hub[0] + off_v * self.hub[1])

    def x_at(self, u: Array, v: Array) -> Array:
        """Give x across the axis of points (n,)."""
        off_u, off_v = u - self.origin[0], v - self.origin[1]
        return np.asarray(off_v * self.hub[0] - off_u * self.hub[1])


def _interval(corners: Array, v: Array) -> tuple[Array, Array]:
    """Give left and right u (n,) at rows v of an outline that begins at its top; equal below it.

    It may run round either way.
    """
    k = int(np.argmax(corners[:, 1]))
    one, other = corners[: k + 1], np.concatenate([corners[k:], corners[:1]])[::-1]
    if corners[-1, 1] < corners[k, 1] and len(other) > 2 and other[0, 1] > other[1, 1]:
        other = other[1:]
    end = corners[k, 0]
    a = np.where(v > corners[k, 1], end, np.interp(v, one[:, 1], one[:, 0]))
    b = np.where(v > corners[k, 1], end, np.interp(v, other[:, 1], other[:, 0]))
    return np.minimum(a, b), np.maximum(a, b)


@dataclass(frozen=True, eq=False)
class Cover:
    """Parts of pixels (H W,) that the whole outline covers, and what of it is the tip's own."""

    whole: Array
    tip: Array


def cover(placed: Placed, window: Window, variance_px2: float) -> Cover:
    """Work out what an outline covers of a window's pixels, blurred."""
    pad = int(np.ceil(3 * np.sqrt(variance_px2)))
    rows = (window.height + 2 * pad) * ROWS
    columns = (window.width + 2 * pad) * COLUMNS
    v = window.v - pad - 0.5 + (np.arange(rows) + 0.5) / ROWS
    u = window.u - pad - 0.5 + np.arange(columns + 1) / COLUMNS
    left, right = placed.interval(v)
    whole = _covered(u, left, right)
    inner_left, inner_right, share = placed.tip_interval(v)
    tip = _covered(u, inner_left, inner_right) * share.astype(np.float32)[:, None]
    return Cover(*(_to_pixels(part, window, pad, variance_px2) for part in (whole, tip)))


def _covered(u: Array, left: Array, right: Array) -> Array:
    """Give the part of each cell between borders u (n + 1,) from left to right (m,): (m, n)."""
    at_left = np.clip((left[:, None] - u[:-1]) * COLUMNS, 0, 1)
    at_right = np.clip((right[:, None] - u[:-1]) * COLUMNS, 0, 1)
    return np.asarray(at_right - at_left, np.float32)


def _to_pixels(cells: Array, window: Window, pad: int, variance_px2: float) -> Array:
    if pad:
        sigma = float(np.sqrt(variance_px2))
        cells = np.asarray(
            cv2.GaussianBlur(
                cells, (0, 0), sigma * COLUMNS, sigmaY=sigma * ROWS, borderType=cv2.BORDER_REPLICATE
            )
        )
    inner = cells[
        pad * ROWS : len(cells) - pad * ROWS, pad * COLUMNS : cells.shape[1] - pad * COLUMNS
    ]
    pixels = inner.reshape(window.height, ROWS, window.width, COLUMNS).mean(axis=(1, 3))
    return np.asarray(pixels.reshape(-1), np.float64)


def _mean_brightness(low: Array, high: Array, even: int, odd: int) -> Array:
    """Give the means (n, 1 + even + odd) of constant and modes from s = low to high (n,)."""
    wide = np.maximum(high - low, 1e-3)
    middle = (low + high) / 2
    sums = brightness_integral(np.concatenate([middle - wide / 2, middle + wide / 2]))
    reach = np.clip(middle + wide / 2, -1, 1) - np.clip(middle - wide / 2, -1, 1)
    means = (sums[len(low) :] - sums[: len(low)]) / np.maximum(reach, 1e-6)[:, None]
    first = 1 + EVEN_MODES
    return np.concatenate([means[:, : 1 + even], means[:, first : first + odd]], axis=1)


def _seen(u: Array, low: Array, high: Array, reach: float) -> tuple[Array, Array]:
    """Give the part of [low, high] within `reach` of u as s from -1 to 1: both ends (n,)."""
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-3)
    begin = np.clip((u - reach - middle) / half, -1, 1)
    end = np.clip((u + reach - middle) / half, -1, 1)
    # Beyond an edge: what is right at it.
    return np.minimum(begin, 0.999), np.maximum(end, -0.999)


def shading(placed: Placed, window: Window, variance_px2: float) -> tuple[Array, Array, Array]:
    """Give what the brightness of background, shaft and tip is made of, each (H W, n)."""
    grid_v, grid_u = np.divmod(np.arange(window.height * window.width), window.width)
    v, u = (grid_v + window.v).astype(np.float64), (grid_u + window.u).astype(np.float64)
    ground = np.column_stack(
        [np.ones(len(u)), grid_u / window.width - 0.5, grid_v / window.height - 0.5]
    )
    z, x = placed.z_at(u, v), placed.x_at(u, v)
    depth = max(placed.depth_px, 1.0)
    reach = 0.5 + float(np.sqrt(variance_px2))
    half = np.full(len(x), placed.half_px)
    on_shaft = _mean_brightness(*_seen(x, -half, half, reach), SHAFT_EVEN, SHAFT_ODD)
    change = np.clip(z / depth, 0, 2)[:, None] - 0.5
    rows = np.arange(window.v, window.v + window.height, dtype=np.float64)
    low, high = (side[grid_v] for side in placed.tip_interval(rows)[:2])
    s = (u - (low + high) / 2) / np.maximum((high - low) / 2, 0.5)
    on_tip = _mean_brightness(*_seen(u, low, high, reach), TIP_EVEN, TIP_ODD)
    return (
        ground,
        np.concatenate([on_shaft, change], axis=1),
        np.concatenate([on_tip, change, s[:, None].clip(-1, 1) * change], axis=1),
    )
