"""A printed pattern as a raster, fine enough that cameras see its edges where they are."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.target import Target

STEP_MM = 0.02
"""A quarter of a pixel of the paper's cameras."""
MOST_TEXELS = 16_000_000
FINER = 8
"""Points each way in a texel that an edge crosses."""
ROWS = 256
"""Worked on at a time."""
NARROW = 0.5
"""Variance in texels below which a sampled Gaussian's is not what it should be."""
ALIGNED, ASTRIDE = 1 / 12, 1 / 4
"""Variance, in steps, of an edge between texels by interpolation, and of one that runs anyhow."""


@dataclass(frozen=True, eq=False)
class InkRaster:
    """How black a print is, mean over texels.

    Attributes
    ----------
    values
        (rows, columns) float32, 0 to 1; bare all around.
    corner_mm
        (2,) middle of the first texel, nominal board coordinates.
    step_mm
        Between texels, both ways.
    """

    values: NDArray[np.float32]
    corner_mm: Array
    step_mm: float


def ink_raster(target: Target, edge_blur_mm: float) -> InkRaster:
    """Rasterise a target's ink.

    Texels that no edge crosses are exact, others are means over `FINER` x `FINER` points, so that
    linear interpolation leaves each edge in its place.

    Parameters
    ----------
    target
        What is printed.
    edge_blur_mm
        Standard deviation of the softness of its edges. It is never less than what texels and the
        interpolation between them make of a sharp one: 0.3 steps, and 0.5 of an edge across texels.
    """
    size = target.high - target.low
    step = max(STEP_MM, float(np.sqrt(size.prod() / MOST_TEXELS)))
    # Steps that divide the lattice put straight edges on the texels' borders.
    step = target.pitch_mm / np.ceil(target.pitch_mm / step)
    border = 2 + int(np.ceil(4 * edge_blur_mm / step))
    columns, rows = np.ceil(size / step).astype(int) + 2 * border
    low = target.low - border * step
    values = np.concatenate([
        _rows(target, low, step, int(columns), range(start, min(start + ROWS, int(rows))))
        for start in range(0, int(rows), ROWS)
    ])  # fmt: skip
    astride = ((values > 0) & (values < 1)).any()
    variance = (edge_blur_mm / step) ** 2 - (ASTRIDE if astride else ALIGNED)
    if variance > 0:
        kernel = _kernel(variance)
        values = cv2.sepFilter2D(values, -1, kernel, kernel, borderType=cv2.BORDER_REPLICATE)
    return InkRaster(values.astype(np.float32), low + step / 2, float(step))


def _kernel(variance: float) -> Array:
    """Give a discrete Gaussian of this variance, in texels; a narrow one has three weights."""
    if variance < NARROW:
        return np.array([variance / 2, 1 - variance, variance / 2])
    sigma = np.sqrt(variance)
    x = np.arange(-np.ceil(4 * sigma), np.ceil(4 * sigma) + 1)
    weights = np.exp(-(x**2) / (2 * variance))
    kernel: Array = weights / weights.sum()
    return kernel


def _rows(
    target: Target, low: Array, step: float, columns: int, rows: range
) -> NDArray[np.float32]:
    """Give rows of texels (rows, columns)."""
    nudge = 1e-6  # corners of texels lie on straight edges, their neighbourhood does not
    found = []
    for du in (nudge, 1 - nudge):
        for dv in (nudge, 1 - nudge):
            st = _grid(low, step, np.arange(columns) + du, np.array(rows) + dv)
            found.append(target.ink(st).reshape(len(rows), columns))
    corners = np.stack(found)
    values: NDArray[np.float32] = corners[0].astype(np.float32)
    row, column = np.nonzero(corners.min(axis=0) != corners.max(axis=0))
    if len(row):
        inside = (np.arange(FINER) + 0.5) / FINER
        down, across = np.meshgrid(inside, inside, indexing="ij")
        columns_at = column[:, None] + across.reshape(-1)
        rows_at = rows.start + row[:, None] + down.reshape(-1)
        st = low + step * np.stack([columns_at.reshape(-1), rows_at.reshape(-1)], axis=1)
        ink = target.ink(st)
        values[row, column] = ink.reshape(len(row), -1).mean(axis=1)
    return values


def _grid(low: Array, step: float, columns: ArrayLike, rows: ArrayLike) -> Array:
    s, t = np.meshgrid(low[0] + np.asarray(columns) * step, low[1] + np.asarray(rows) * step)
    return np.stack([s.reshape(-1), t.reshape(-1)], axis=1)
