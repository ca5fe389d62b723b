"""The pixels near a shaft's two edges, averaged: what the shaft is fitted to, and how noisy it is.

The shaft is cut into blocks of rows, and the pixels of a block are averaged in narrow bins of their
distance from the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.saturated import FULL_SCALE
from simtip.detect.subpixel.shaft import Shaft
from simtip.geometry import Array

BLOCK_ROWS, LEAST_BLOCKS = 48, 4
"""Rows of a block; a shaft of fewer such blocks has smaller ones, or else nothing would tell its
slope."""

BIN_PX = 1 / 8

BINS_MERGED = 2

INNER_PX, OUTER_PX = 4.5, 5.0
"""Pixels so far inside and outside an edge count, and three deviations of the blur more."""

EDGE_BIN_PX, EDGE_BEGIN, EDGE_DEPTH_PX = 0.25, 0.2, (2.5, 7.0)
"""Bins of the profile; an edge begins where it reaches that share of the largest contrast; and the
rim is looked for at least and at most so far inside of there."""


@dataclass(frozen=True, eq=False)
class Bins:
    """Pixels near both edges, averaged: (blocks, bins).

    Distance from the axis that they were sorted by, across it, px; gray value; number of pixels;
    of each block the row, and u of that axis there; and each bin's number, ascending: those without
    a pixel are left out. And whether pixels were left out because they do not count.
    """

    x: Array
    value: Array
    count: Array
    v: Array
    axis_u: Array
    number: NDArray[np.intp]
    gaps: bool = False


def block_rows(rows: NDArray[np.intp]) -> int:
    """Give how many rows make a block."""
    return max(1, min(BLOCK_ROWS, len(rows) // LEAST_BLOCKS))


def sort_pixels(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    shaft: Shaft,
    *,
    saturated_dn: float = np.nan,
) -> Bins:
    """Average the pixels near the edges by block and by distance from the axis.

    Saturated ones, NaN, do not count, or count as `saturated_dn`.
    """
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
    lost = np.isnan(value) & wanted
    gaps = bool(lost.any())
    if gaps:
        value = np.where(lost, np.float32(saturated_dn), value)
        wanted &= ~np.isnan(value)
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
        np.flatnonzero(used),
        gaps,
    )


def merge(bins: Bins) -> Bins:
    """Merge neighbouring bins, and blocks until `LEAST_BLOCKS` to twice as many are left.

    Along a needle that stands upright, whole columns of pixels are a bin each, with empty ones
    between them: those have no neighbour.
    """
    tall = max(1, len(bins.v) // LEAST_BLOCKS)
    first = len(bins.v) % tall
    wide, begins = np.unique(bins.number // BINS_MERGED, return_index=True)

    def summed(values: Array) -> Array:
        kept = values[first:].reshape(-1, tall, values.shape[1]).sum(axis=1)
        return np.asarray(np.add.reduceat(kept, begins, axis=1))

    count = summed(bins.count)
    there = np.maximum(count, 1)
    x, value = (summed(each * bins.count) / there for each in (bins.x, bins.value))
    v, axis_u = (each[first:].reshape(-1, tall).mean(axis=1) for each in (bins.v, bins.axis_u))
    return Bins(x, value, count, v, axis_u, wide)


def edges_px(
    image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft
) -> tuple[float, float]:
    """Give how far left and right of the axis the mean profile's edges are, px.

    An edge is halfway between the ground and the rim next to it. It is less exact than a fit, and
    free of the fit's trade between width, blur and brightness. Saturated pixels, NaN, are bright:
    they show that something is there, but not how much contrast is usual.
    """
    rows = rows[len(rows) % block_rows(rows) :]
    bins = sort_pixels(image, rows, shaft)
    sides = _contrasts(bins, shaft)
    most = max(float(contrast.max()) for _, contrast in sides)
    if bins.gaps:
        sides = _contrasts(sort_pixels(image, rows, shaft, saturated_dn=FULL_SCALE), shaft)
    begins = [_outermost(*side, EDGE_BEGIN * most) for side in sides]
    # How far an edge is blurred, by the side that is darkest at its rim.
    rise = min(
        begin - _outermost(*side, most / 2) for begin, side in zip(begins, sides, strict=True)
    )
    depth = float(np.clip(3 * rise, *EDGE_DEPTH_PX))
    left, right = (
        _outermost(
            x, contrast, contrast[(x > begin - depth) & (x <= begin + EDGE_BIN_PX)].max() / 2
        )
        for begin, (x, contrast) in zip(begins, sides, strict=True)
    )
    return left, right


def _contrasts(bins: Bins, shaft: Shaft) -> list[tuple[Array, Array]]:
    """Give `_contrast` to the left and to the right of a shaft's axis."""
    return [_contrast(bins, side, float(shaft.width[0])) for side in (-1, 1)]


def _contrast(bins: Bins, side: int, half: float) -> tuple[Array, Array]:
    """Give distances (n,) to one side of the axis, ascending, and the contrast to the ground."""
    away = side * bins.x
    wanted = (away > 0) & (bins.count > 0)
    if not wanted.any():  # all of it saturated
        return np.array([half]), np.zeros(1)
    k = np.rint(away[wanted] / EDGE_BIN_PX).astype(np.intp)
    number = np.bincount(k, bins.count[wanted])
    total = np.bincount(k, (bins.count * bins.value)[wanted])
    seen = np.flatnonzero(number)
    x, value = EDGE_BIN_PX * seen.astype(np.float64), total[seen] / number[seen]
    ground = float(np.median(value[x > half + 2])) if (x > half + 2).any() else float(value[-1])
    return x, np.asarray(np.abs(value - ground), np.float64)


def _outermost(x: Array, contrast: Array, level: float) -> float:
    """Give the farthest distance at which the contrast comes up to a level."""
    above = np.flatnonzero(contrast >= level)
    j = int(above[-1]) if len(above) else 0
    if j + 1 == len(x) or contrast[j] < level:
        return float(x[j])
    step = (contrast[j] - level) / (contrast[j] - contrast[j + 1])
    return float(x[j] + step * (x[j + 1] - x[j]))
