"""Draw a needle's outline on a grid of cells: what is body, tip and facet, and the place across.

The place across is s, -1 at the left side and 1 at the right. Brightness is given over s, and its
mean over a cell is exact along the row, the edges of the needle included.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.refine.brightness import NODES, nodes
from simtip.refine.cells import COLUMNS, ROWS, Cells
from simtip.refine.outline import Outline

LEAST_WIDTH_PX = 1e-6


@dataclass(frozen=True, eq=False)
class Drawing:
    """An outline on cells (r, c).

    Attributes
    ----------
    cells, outline
        What is drawn on what.
    place, share
        (r, c + 1) node at or before each border between cells, and how far on the next one is.
    step
        (r, c) change of s across each cell.
    there
        (r, c) part of each cell that is not in front of the foremost point.
    nose
        (r, c) part of what is there that is the tip's own.
    """

    cells: Cells
    outline: Outline
    place: NDArray[np.intp]
    share: Array
    step: Array
    there: Array
    nose: Array

    @classmethod
    def of(cls, outline: Outline, cells: Cells) -> Drawing:
        """Draw."""
        x, z = outline.place(cells.u[None], cells.v[:, None])
        left, right = outline.sides(z)
        half = np.maximum((right - left) / 2, LEAST_WIDTH_PX)
        s = (x - (left + right) / 2) / half
        inner = np.clip(s, -1, 1)
        at = (np.arcsin(inner) / np.pi + 0.5) * NODES
        place = np.minimum(at.astype(np.intp), NODES - 1)
        sines = nodes()
        share = (inner - sines[place]) / (sines[place + 1] - sines[place])
        # How much z changes within a cell: what lies across an end is softened by as much.
        soft = abs(outline.hub[1]) / ROWS + abs(outline.hub[0]) / COLUMNS
        middle = (z[:, 1:] + z[:, :-1]) / 2
        there = np.clip((middle - outline.first_px) / soft + 0.5, 0, 1)
        across = (inner[:, 1:] + inner[:, :-1]) / 2
        begin = outline.depth_px + outline.bulge_px * np.sqrt(1 - across**2)
        nose = np.clip((begin - middle) / soft + 0.5, 0, 1)
        step = np.maximum(np.diff(s, axis=1), 1e-9)
        return cls(cells, outline, place, share, step, there, nose)

    def mean(self, table: Array) -> Array:
        """Give the mean of a brightness over each cell, nothing outside the needle: (r, c).

        `table` (NODES + 1,) is its integral over s from -1 to the nodes.
        """
        low = table[self.place]
        at = low + self.share * (table[self.place + 1] - low)
        return np.asarray(np.diff(at, axis=1) / self.step * self.there)

    @cached_property
    def body(self) -> Array:
        """(r, c): part of each cell that the needle covers."""
        return self.mean(nodes() + 1)

    @cached_property
    def facets(self) -> tuple[Array | None, ...]:
        """(r, c) part of each cell that each facet covers; None for those that look away."""
        return tuple(None if f is None else _covered(f, self.cells) for f in self.outline.facets)

    @cached_property
    def round_part(self) -> Array:
        """(r, c): of what the needle covers, the part that no facet does."""
        flat = np.zeros_like(self.body)
        for facet in self.facets:
            if facet is not None:
                flat += facet
        return np.asarray(np.clip(1 - flat / np.maximum(self.body, 1e-9), 0, 1))


def _covered(corners: Array, cells: Cells) -> Array:
    """Give the part (r, c) of each cell within a convex polygon (n, 2) u, v."""
    k = int(np.argmin(corners[:, 1]))
    turned = np.roll(corners, -k, axis=0)
    m = int(np.argmax(turned[:, 1]))
    one, other = turned[: m + 1], np.concatenate([turned[m:], turned[:1]])[::-1]
    a, b = (np.interp(cells.v, side[:, 1], side[:, 0]) for side in (one, other))
    inside = (cells.v > turned[0, 1]) & (cells.v < turned[m, 1])
    low, high = np.minimum(a, b)[:, None], np.maximum(a, b)[:, None]
    width = np.diff(cells.u)
    part = np.clip(np.minimum(high, cells.u[1:]) - np.maximum(low, cells.u[:-1]), 0, None)
    return np.asarray(part / width * inside[:, None])
