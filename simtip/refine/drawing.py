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
from simtip.refine.outline import Outline, at_z

LEAST_WIDTH_PX = 1e-6


@dataclass(frozen=True, eq=False)
class Drawing:
    """An outline on cells (r, c).

    Attributes
    ----------
    cells, outline
        What is drawn on what.
    place, share
        (r, c + 1) node at or before each border between cells, moved to the needle's edge where it
        lies outside, and how far on the next node is.
    body
        (r, c) part of each cell that the needle covers.
    scale
        (r, c) that part, per change of s in it.
    nose
        (r, c) part of what is covered that is the tip's own.
    """

    cells: Cells
    outline: Outline
    place: NDArray[np.intp]
    share: Array
    body: Array
    scale: Array
    nose: Array

    @classmethod
    def of(cls, outline: Outline, cells: Cells, *, curved: bool) -> Drawing:
        """Draw.

        On a `curved` tip s is the place between the outline's sides; else what is no facet is
        still the shaft's surface, and s the place between the shaft's sides.
        """
        rows = crossings(outline.corners, cells.v)
        u = rows.clipped(cells.u)
        x, z = outline.place(u, rows.v[:, None])
        sides = (outline.left, outline.right) if curved else outline.shaft
        low, high = (at_z(side, z) for side in sides)
        half = np.maximum((high - low) / 2, LEAST_WIDTH_PX)
        s = np.clip((x - (low + high) / 2) / half, -1, 1)
        at = (np.arcsin(s) / np.pi + 0.5) * NODES
        place = np.minimum(at.astype(np.intp), NODES - 1)
        sines = nodes()
        share = (s - sines[place]) / (sines[place + 1] - sines[place])
        body = rows.share[:, None] * np.diff(u, axis=1) / np.diff(cells.u)
        step = np.diff(s, axis=1)
        scale = np.where(step > 0, body / np.where(step > 0, step, 1.0), 0.0)
        # What lies across the tip's end is softened by as much as z changes in a cell.
        soft = abs(outline.hub[1]) / ROWS + abs(outline.hub[0]) / COLUMNS
        across = (s[:, 1:] + s[:, :-1]) / 2
        last = outline.depth_px + outline.bulge_px * np.sqrt(1 - across**2)
        nose = np.clip((last - (z[:, 1:] + z[:, :-1]) / 2) / soft + 0.5, 0, 1)
        return cls(cells, outline, place, share, body, scale, nose)

    def mean(self, table: Array) -> Array:
        """Give the mean of a brightness over each cell, nothing outside the needle: (r, c).

        `table` (NODES + 1,) is its integral over s from -1 to the nodes.
        """
        low = table[self.place]
        at = low + self.share * (table[self.place + 1] - low)
        return np.asarray(np.diff(at, axis=1) * self.scale)

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


@dataclass(frozen=True, eq=False)
class Rows:
    """Where rows of cells cross a convex polygon: each (r,).

    Attributes
    ----------
    v
        The middle of the part of the row that the polygon reaches.
    share
        How much of the row that is.
    begin, end
        u at which v enters and leaves it; equal where it is missed.
    """

    v: Array
    share: Array
    begin: Array
    end: Array

    def clipped(self, borders: Array) -> Array:
        """Move borders (c + 1,) that lie outside to the edge: (r, c + 1)."""
        return np.clip(borders[None], self.begin[:, None], self.end[:, None])


def crossings(corners: Array, v: Array) -> Rows:
    """Cross a convex polygon (n, 2) u, v with rows between borders v (r + 1,)."""
    turned = np.roll(corners, -int(np.argmin(corners[:, 1])), axis=0)
    m = int(np.argmax(turned[:, 1]))
    low, high = np.clip(v[:-1], turned[0, 1], None), np.clip(v[1:], None, turned[m, 1])
    share = np.clip((high - low) / np.diff(v), 0, 1)
    middle = np.where(share > 0, (low + high) / 2, (v[:-1] + v[1:]) / 2)
    one, other = turned[: m + 1], np.concatenate([turned[m:], turned[:1]])[::-1]
    a, b = (np.interp(middle, side[:, 1], side[:, 0]) for side in (one, other))
    begin = np.minimum(a, b)
    return Rows(middle, share, begin, np.where(share > 0, np.maximum(a, b), begin))


def _covered(corners: Array, cells: Cells) -> Array:
    """Give the part (r, c) of each cell within a convex polygon (n, 2) u, v."""
    rows = crossings(corners, cells.v)
    return np.asarray(
        rows.share[:, None] * np.diff(rows.clipped(cells.u), axis=1) / np.diff(cells.u)
    )
