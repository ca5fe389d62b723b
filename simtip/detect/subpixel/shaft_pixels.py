"""The pixels near a shaft's two edges, averaged: what the shaft is fitted to, and how noisy it is.

The shaft is cut into blocks of rows, and the pixels of a block are averaged in narrow bins of their
distance from the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array

BLOCK_ROWS, LEAST_BLOCKS = 48, 4
"""Rows of a block; a shaft of fewer such blocks has smaller ones, or else nothing would tell its
slope."""

BIN_PX = 1 / 8

BINS_MERGED = 2

INNER_PX, OUTER_PX = 4.5, 5.0
"""Pixels so far inside and outside an edge count, and three deviations of the blur more."""

EDGE_BIN_PX, EDGE_DEPTH_PX = 0.25, 4.0

NOISE_BINS = 12

LEAST_NOISE_DN2 = 0.02


@dataclass(frozen=True, eq=False)
class Bins:
    """Pixels near both edges, averaged: (blocks, bins).

    Distance from the axis that they were sorted by, across it, px; gray value; number of pixels;
    and of each block the row, and u of that axis there.
    """

    x: Array
    value: Array
    count: Array
    v: Array
    axis_u: Array


def block_rows(rows: NDArray[np.intp]) -> int:
    """Give how many rows make a block."""
    return max(1, min(BLOCK_ROWS, len(rows) // LEAST_BLOCKS))


def sort_pixels(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Bins:
    """Average the pixels near the edges by block and by distance from the axis."""
    v = rows.astype(np.float64)
    centre, tilt = shaft.axis_u(v), np.hypot(1, shaft.slope(v))
    half = shaft.half_px(v)
    spread = 3 * np.sqrt(float(shaft.variance.max()))
    inner = min(INNER_PX + spread, float(half.min()))
    first = np.rint(centre - (half + OUTER_PX + spread) * tilt).astype(np.intp)
    count = int(np.ceil(2 * float(((half + OUTER_PX + spread) * tilt).max()))) + 1
    u = first[:, None] + np.arange(count)
    x = (u - centre[:, None]) / tilt[:, None]
    away = np.abs(x) - half[:, None]
    wanted = (away > -inner) & (away < OUTER_PX + spread) & (u >= 0) & (u < image.shape[1])
    value = image[rows[:, None], np.clip(u, 0, image.shape[1] - 1)]
    height = block_rows(rows)
    blocks = len(rows) // height
    block = np.minimum(np.arange(len(rows)) // height, blocks - 1)
    reach = int(np.ceil((float(half.max()) + OUTER_PX + spread + 1) / BIN_PX))
    k = (np.rint(x / BIN_PX).astype(np.intp) + reach + block[:, None] * (2 * reach + 1))[wanted]
    total = blocks * (2 * reach + 1)
    number = np.bincount(k, minlength=total).astype(np.float64)
    there = np.maximum(number, 1)
    mean_x = np.bincount(k, x[wanted], total) / there
    mean_y = np.bincount(k, value[wanted], total) / there
    used = number.reshape(blocks, -1).any(axis=0)
    shape = (blocks, 2 * reach + 1)
    rows_of = np.bincount(block, v) / np.bincount(block)
    return Bins(
        mean_x.reshape(shape)[:, used],
        mean_y.reshape(shape)[:, used],
        number.reshape(shape)[:, used],
        rows_of,
        shaft.axis_u(rows_of),
    )


def merge(bins: Bins) -> Bins:
    """Merge neighbouring bins, and blocks until `LEAST_BLOCKS` to twice as many are left."""
    tall = max(1, len(bins.v) // LEAST_BLOCKS)
    first = len(bins.v) % tall
    odd = bins.count.shape[1] % BINS_MERGED
    shape = (-1, tall, bins.count.shape[1] // BINS_MERGED, BINS_MERGED)

    def summed(values: Array) -> Array:
        kept = values[first:, : values.shape[1] - odd]
        return np.asarray(kept.reshape(shape).sum(axis=(1, 3)))

    count = summed(bins.count)
    there = np.maximum(count, 1)
    x, value = (summed(each * bins.count) / there for each in (bins.x, bins.value))
    v, axis_u = (each[first:].reshape(-1, tall).mean(axis=1) for each in (bins.v, bins.axis_u))
    return Bins(x, value, count, v, axis_u)


def edge_half_px(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> float:
    """Give the half width at which the mean profile is halfway between ground and needle, px.

    It is less exact than a fit, and free of the fit's trade between width, blur and brightness.
    """
    bins = sort_pixels(image, rows[len(rows) % block_rows(rows) :], shaft)
    away = np.abs(bins.x).reshape(-1)
    k = np.rint(away / EDGE_BIN_PX).astype(np.intp)
    number = np.bincount(k, bins.count.reshape(-1))
    total = np.bincount(k, (bins.count * bins.value).reshape(-1))
    seen = np.flatnonzero(number)
    x, value = seen * EDGE_BIN_PX, total[seen] / number[seen]
    half = float(shaft.width[0])
    ground = float(np.median(value[x > half + 2])) if (x > half + 2).any() else float(value[-1])
    within = (x > half - EDGE_DEPTH_PX) & (x < half)
    if not within.any():
        return half
    dark = int(np.flatnonzero(within)[np.argmax(np.abs(value[within] - ground))])
    share = (value[dark:] - ground) / (value[dark] - ground)
    (below,) = np.nonzero(share < 0.5)
    if not len(below) or below[0] == 0:
        return half
    j = int(below[0])
    step = (share[j - 1] - 0.5) / (share[j - 1] - share[j])
    return float(x[dark + j - 1] + step * (x[dark + j] - x[dark + j - 1]))


def noise_of(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Array:
    """Give constant and slope of the noise's variance against the level, DN^2.

    From second differences along the needle, in which all that is smooth cancels; medians, so that
    dirt does not count.
    """
    v = rows.astype(np.float64)
    half = float(shaft.half_px(v).max())
    reach = np.arange(-int(half + OUTER_PX), int(half + OUTER_PX) + 1)
    # Along the axis, not along u: a slanting needle's edges would count as noise.
    columns = np.rint(shaft.axis_u(v)).astype(np.intp)[:, None] + reach
    values = image[rows[:, None], np.clip(columns, 0, image.shape[1] - 1)]
    above, at, below = values[:-2], values[1:-1], values[2:]
    off = ((above - 2 * at + below) ** 2 / 6).reshape(-1)
    level = ((above + at + below) / 3).reshape(-1)
    parts = np.array_split(np.argsort(level), NOISE_BINS)
    mean = np.array([level[part].mean() for part in parts])
    # The median of a squared normal number is 0.4549 of its mean.
    variance = np.array([np.median(off[part]) / 0.4549 for part in parts])
    slope = max(float(np.polyfit(mean, variance, 1)[0]), 0.0)
    constant = max(float(np.median(variance - slope * mean)), LEAST_NOISE_DN2)
    return np.array([constant, slope])
