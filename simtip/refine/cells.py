"""From fine cells to pixels: the lens's blur and the pixel's area."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.special import ndtr

from simtip.detect.subpixel.picture import Window
from simtip.geometry import Array

ROWS, FINE_ROWS, COLUMNS = 4, 16, 2
"""Cells to a pixel, and where the needle ends. Along a row, edges within a cell are exact."""

FINE_PX = 4
"""So many rows of pixels before and after the needle's end are fine."""

REACH = 4.0
"""Deviations of the blur beyond the pixels that cells go on for."""


@dataclass(frozen=True, eq=False)
class Cells:
    """A grid of cells over a window of pixels and the blur's reach around it.

    Attributes
    ----------
    v
        (r + 1,) borders between rows of cells.
    u
        (c + 1,) borders between columns of cells.
    down, across
        (H, r) and (W, c): how much of each cell's row, or column, is in each pixel's.
    """

    v: Array
    u: Array
    down: sparse.csr_array[np.float64]
    across: Array

    @classmethod
    @lru_cache(maxsize=16)
    def over(cls, window: Window, sigma: float, end: int) -> Cells:
        """Lay the grid for a Gaussian blur of a deviation, px.

        `end` is the row of pixels in which the needle ends.
        """
        pad = int(np.ceil(REACH * sigma))
        rows = np.arange(window.v - pad, window.v + window.height + pad)
        v = _borders(rows, np.where(np.abs(rows - end) <= FINE_PX, FINE_ROWS, ROWS))
        columns = np.arange(window.u - pad, window.u + window.width + pad)
        u = _borders(columns, np.full(len(columns), COLUMNS))
        down = _shares(v, rows[pad : len(rows) - pad], sigma)
        across = _shares(u, columns[pad : len(columns) - pad], sigma)
        return cls(v, u, sparse.csr_array(down), across)

    def pixels(self, values: list[Array]) -> Array:
        """Give pixels (k, H, W) of k pictures of cells (r, c)."""
        stack = np.stack(values, axis=1)
        rows, k, columns = stack.shape
        narrow = stack.reshape(rows * k, columns) @ self.across.T
        made = np.asarray(self.down @ narrow.reshape(rows, -1))
        return np.ascontiguousarray(made.reshape(-1, k, len(self.across)).swapaxes(0, 1))


def _borders(pixels: NDArray[np.intp], parts: NDArray[np.intp]) -> Array:
    """Give the borders of cells: each pixel in so many parts."""
    first = np.cumsum(parts) - parts
    k = np.arange(parts.sum()) - np.repeat(first, parts)
    begin = np.repeat(pixels - 0.5, parts) + k / np.repeat(parts, parts)
    return np.append(begin, pixels[-1] + 0.5)


def _shares(borders: Array, pixels: NDArray[np.intp], sigma: float) -> Array:
    """Give the part of each pixel's light that is from between each two borders: (n, m)."""
    off = borders - pixels[:, None]
    step = _ramp(off + 0.5, sigma) - _ramp(off - 0.5, sigma)
    return np.asarray(np.diff(step, axis=1))


def _ramp(x: Array, sigma: float) -> Array:
    """Give the integral of the blurred step from -inf to x."""
    if sigma == 0:
        return np.maximum(x, 0.0)
    s = x / sigma
    return np.asarray(x * ndtr(s) + sigma * np.exp(-0.5 * s**2) / np.sqrt(2 * np.pi))
