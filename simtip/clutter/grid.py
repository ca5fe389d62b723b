"""Texels on the board: where they are, and how fine."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

MAX_TEXELS = 10_000_000


@dataclass(frozen=True)
class Grid:
    """Square texels whose centres lie at whole multiples of the step from the board's centre.

    Texel (j, i) is centred at ``corner + step * (i, j)`` in board coordinates (s, t), mm.

    Attributes
    ----------
    step_mm
        The texels' side.
    first
        The corner texel's (i, j), counted from the board's centre.
    shape
        (rows, cols).
    """

    step_mm: float
    first: tuple[int, int]
    shape: tuple[int, int]

    @classmethod
    def over(
        cls, low_mm: ArrayLike, high_mm: ArrayLike, step_mm: float, limit: int = MAX_TEXELS
    ) -> Grid:
        """Cover a box (2,), (2,) with texels of a step or, if that is too many, a larger one.

        The step grows by quarter octaves, so boxes of about one size share it. The outermost
        centres lie on or outside the box.
        """
        low, high = np.asarray(low_mm, dtype=np.float64), np.asarray(high_mm, dtype=np.float64)
        for quarter in range(200):
            step = step_mm * 2 ** (quarter / 4)
            first = np.floor(low / step)
            cols, rows = np.ceil(high / step) - first + 1
            if cols * rows <= limit:
                break
        return cls(step, (int(first[0]), int(first[1])), (int(rows), int(cols)))

    @property
    def corner_mm(self) -> Array:
        """(2,) the centre of texel (0, 0)."""
        return self.step_mm * np.array(self.first, dtype=np.float64)

    def axes(self) -> tuple[Array, Array]:
        """Give the texels' s (cols,) and t (rows,), mm."""
        (i, j), (rows, cols) = self.first, self.shape
        s = self.step_mm * np.arange(i, i + cols, dtype=np.float64)
        return s, self.step_mm * np.arange(j, j + rows, dtype=np.float64)

    def cells(self, points_mm: Array) -> Array:
        """Map board points (..., 2) to texel units, in which texel (j, i) is [i, i+1) x [j, j+1).

        Counted from the board's centre, so that rounding does not depend on the box.
        """
        scaled: Array = points_mm / self.step_mm + 0.5
        return scaled

    def reaches(self, low_mm: Array, high_mm: Array) -> bool:
        """Say whether a box may touch a texel."""
        first = np.array(self.first)
        last = first + np.array(self.shape[::-1]) - 1
        low, high = np.floor(self.cells(low_mm)), np.floor(self.cells(high_mm))
        return bool((high >= first).all() and (low <= last).all())

    @property
    def area_mm2(self) -> float:
        """Of all texels together."""
        return math.prod(self.shape) * self.step_mm**2
