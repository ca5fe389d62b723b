"""What a camera makes of a needle's tip: how much of each pixel an outline covers.

Rows finer than pixels are covered exactly along the row, then blurred and averaged.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.blur import blurred
from simtip.geometry import Array

ROWS, COLUMNS = 4, 2
"""Cells to a pixel."""

NEAR_END, FINE = 2.0, 8
"""Rows of cells so near an end, of a blunt outline or a facet, are looked at so many times: they
are covered in part."""

LEAST_COVER = 1e-3
"""Of a pixel that shows something."""

SHARP_PX2 = 0.005
"""Variance of a blur that is none: it takes a part in five hundred across a cell's border."""


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels of the turned image: first column and row, and how many."""

    u: int
    v: int
    width: int
    height: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.height, self.width


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
    tilt
        Sine of the axis, towards the hub, along the line of sight: the shaft begins at a circle,
        which is seen as an arc.
    """

    corners: Array
    facet: Array | None
    origin: Array
    hub: Array
    half_px: float
    depth_px: float
    tilt: float = 0.0

    def intervals(self, v: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Give left and right u (n,) at rows v, of the whole outline and of the tip's own part.

        Both are equal below the outline's end. Last comes whether the row has a part of the tip.
        """
        left, right = _interval(self.corners, v)
        if self.facet is None:
            return left, right, left, right, np.ones(len(v))
        if len(self.facet) == 0:
            return left, right, left, left, np.zeros(len(v))
        k = int(np.argmin(self.facet[:, 1]))
        low, high = _interval(np.concatenate([self.facet[k:], self.facet[:k]]), v)
        there = (v >= self.facet[k, 1]).astype(np.float64)
        return left, right, np.clip(low, left, right), np.clip(high, left, right), there

    @property
    def ends(self) -> list[float]:
        """Give the rows at which the outline ends and a facet begins: there it is blunt."""
        ends = [float(self.corners[:, 1].max())]
        if self.facet is not None and len(self.facet):
            ends.append(float(self.facet[:, 1].min()))
        return ends

    def sides_of(self, v: Array) -> Array:
        """Give `intervals` of pixels in whole rows v (n,), many of them in one row: (5, n)."""
        if not len(v):
            return np.zeros((5, 0))
        first = v.min()
        sides = np.array(self.intervals(np.arange(first, v.max() + 1)))
        return np.asarray(sides[:, (v - first).astype(np.intp)])

    def before_shaft(self, u: Array, v: Array, per_px: int) -> NDArray[np.float32]:
        """Give the part (m, n) of cells at columns u (n,) and rows v (m,) before the shaft's begin.

        `per_px` are the rows of cells to a pixel. What is seen of the circle at which the shaft
        begins is its half towards the camera.
        """
        off_u = (u - self.origin[0]).astype(np.float32)
        off_v = (v - self.origin[1]).astype(np.float32)[:, None]
        hub_u, hub_v = self.hub.astype(np.float32)
        before = np.float32(self.depth_px) - (off_u * hub_u + off_v * hub_v)
        if self.tilt:
            x = off_v * hub_u - off_u * hub_v
            reach = np.maximum(np.float32(self.half_px**2) - x * x, 0)
            before += np.float32(self.tilt) * np.sqrt(reach)
        before *= per_px
        before += np.float32(0.5)
        np.minimum(before, 1, out=before)
        np.maximum(before, 0, out=before)
        return np.asarray(before, np.float32)

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
    a, b = (np.interp(v, side[:, 1], side[:, 0]) for side in (one, other))
    return np.minimum(a, b), np.maximum(a, b)


@dataclass(frozen=True, eq=False)
class Cover:
    """Parts of pixels (H W,) that the whole outline covers, and what of it is the tip's own."""

    whole: Array
    tip: Array


@dataclass(frozen=True, eq=False)
class Rows:
    """Where rows of cells are looked at: in their middles, and more finely where that is too few.

    Attributes
    ----------
    v, row, weight
        (n,) of each row that is looked at, ascending, in which of the rows of cells it is, and its
        part in that.
    first
        (rows,) the first that is in each.
    finely, in_fine
        (k,) rows of cells that are looked at `FINE` times; (n,) which are of those.
    """

    v: Array
    row: NDArray[np.intp]
    weight: Array
    first: NDArray[np.intp]
    finely: NDArray[np.intp]
    in_fine: NDArray[np.bool_]

    def means(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Give the rows of cells' means (rows, m) of values (n, m)."""
        found = values[self.first]
        if len(self.finely):
            fine = values[self.in_fine].reshape(len(self.finely), FINE, -1)
            found[self.finely] = fine.mean(axis=1)
        return found


@dataclass(frozen=True)
class Cells:
    """A window's cells: so many rows to a pixel, and `COLUMNS` to its width if it is blurred.

    Along a row the cover is exact; finer columns are for the blur, and so is a border.
    """

    window: Window
    variance_px2: float
    disc_share: float
    rows_per_px: int = ROWS

    @cached_property
    def pad(self) -> int:
        """Width of the border, px."""
        sharp = self.variance_px2 < SHARP_PX2
        return 0 if sharp else int(np.ceil(3 * np.sqrt(self.variance_px2)))

    @cached_property
    def fine(self) -> int:
        """Columns of cells to a pixel."""
        return COLUMNS if self.pad else 1

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of cells."""
        border = 2 * self.pad
        return (self.window.height + border) * self.rows_per_px, (
            self.window.width + border
        ) * self.fine

    @cached_property
    def rows(self) -> Array:
        """Each row's middle v."""
        first = self.window.v - self.pad - 0.5
        return np.asarray(first + (np.arange(self.shape[0]) + 0.5) / self.rows_per_px)

    def rows_about(self, ends: list[float]) -> Rows:
        """Give the rows, those near an end more finely."""
        number = np.ones(len(self.rows), np.intp)
        for end in ends:
            number[np.abs(self.rows - end) < NEAR_END / self.rows_per_px] = FINE
        row = np.repeat(np.arange(len(number)), number)
        first = np.cumsum(number) - number
        k, of = np.arange(len(row)) - first[row], number[row]
        v = self.rows[row] + ((k + 0.5) / of - 0.5) / self.rows_per_px
        return Rows(v, row, 1 / of, first, np.flatnonzero(number > 1), of > 1)

    @property
    def left(self) -> float:
        """Give u at which the first column begins."""
        return self.window.u - self.pad - 0.5

    @cached_property
    def columns(self) -> Array:
        """Each column's middle u."""
        return np.asarray(self.left + (np.arange(self.shape[1]) + 0.5) / self.fine)

    @property
    def none(self) -> Array:
        """Give the pixels of no cell covered (H W,)."""
        return np.zeros(self.window.height * self.window.width)

    def pixels(self, cells: NDArray[np.float32]) -> Array:
        """Blur cells (rows, columns, ...) and give the pixels' means (H W, ...)."""
        pad, per_px = self.pad, (self.rows_per_px, COLUMNS)
        if pad:
            cells = blurred(cells, self.variance_px2, self.disc_share, per_px)
        v, u = (pad * each for each in per_px)
        inner = cells[v : len(cells) - v, u : cells.shape[1] - u]
        # Whole cells to a pixel: their mean.
        size = self.window.width, self.window.height
        pixels = cv2.resize(inner, size, interpolation=cv2.INTER_AREA)
        return np.asarray(pixels.reshape(-1, *cells.shape[2:]), np.float64)


def cover(placed: Placed, cells: Cells) -> Cover:
    """Work out what an outline covers of a window's pixels, blurred."""
    whole, tip = cell_covers(placed, cells)
    return Cover(cells.pixels(whole), cells.none if tip is None else cells.pixels(tip))


def cell_covers(
    placed: Placed, cells: Cells
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Give the parts of cells that an outline covers, and of them the tip's own, if it has any."""
    rows = cells.rows_about(placed.ends)
    left, right, inner_left, inner_right, there = placed.intervals(rows.v)
    whole = _covered(cells, left, right)
    if placed.facet is None:
        tip = whole * placed.before_shaft(cells.columns, rows.v, cells.rows_per_px)
    elif len(placed.facet):
        tip = _covered(cells, inner_left, inner_right)
        tip *= there.astype(np.float32)[:, None]
    else:
        return rows.means(whole), None
    return rows.means(whole), rows.means(tip)


def cover_change(placed: Placed, moved: list[Placed], steps: Array, cells: Cells) -> Cover:
    """Give the derivatives of `cover` by parameters of an outline.

    A cover changes only where an edge is: by how fast that moves, and about an end by what it
    passes in the step.

    Parameters
    ----------
    placed
        The outline.
    moved, steps
        The same with each of some parameters (k,) changed by so much.
    cells
        Of the window.

    Returns
    -------
    change
        (k, H W) each.
    """
    rows, u = cells.rows_about(placed.ends), cells.columns
    *edges, _ = placed.intervals(rows.v)
    shaft = None
    if placed.facet is None:
        before = placed.before_shaft(u, rows.v, cells.rows_per_px)
        shaft = _covered(cells, edges[0], edges[1]), before, rows.means(before)
    whole, tip = [], []
    for other, step in zip(moved, steps, strict=True):
        *now, _ = other.intervals(rows.v)
        change = _edges_change(cells, rows, edges[:2], now[:2], step)
        whole.append(cells.pixels(change))
        if shaft is not None:
            covered, before, mean_before = shaft
            after = other.before_shaft(u, rows.v, cells.rows_per_px)
            moves = covered * ((after - before) / np.float32(step))
            tip_change = change * mean_before
            tip_change += rows.means(moves)
        elif placed.facet is not None and len(placed.facet):
            tip_change = _edges_change(cells, rows, edges[2:], now[2:], step)
        else:
            tip.append(cells.none)
            continue
        tip.append(cells.pixels(tip_change))
    return Cover(np.array(whole), np.array(tip))


def _edges_change(
    cells: Cells, rows: Rows, before: list[Array], after: list[Array], step: float
) -> NDArray[np.float32]:
    """Give how fast cells' cover changes with the left and the right edge of each row."""
    columns = cells.shape[1]
    moved = [new - old for old, new in zip(before, after, strict=True)]
    # Where an outline ends, edges lie across the rows, and pass several columns in a step.
    across = rows.in_fine & ((np.abs(moved[0]) + np.abs(moved[1])) * cells.fine > 1)
    places, speeds = [], []
    for old, by, sign in zip(before, moved, (-cells.fine, cells.fine), strict=True):
        k = np.floor((old + by / 2 - cells.left) * cells.fine).astype(np.intp)
        (seen,) = np.nonzero(~across & (k >= 0) & (k < columns) & (by != 0))
        places.append(rows.row[seen] * columns + k[seen])
        speeds.append(sign * by[seen] * rows.weight[seen] / step)
    total = cells.shape[0] * columns
    found = np.bincount(np.concatenate(places), np.concatenate(speeds), total)
    change = found.astype(np.float32).reshape(cells.shape)
    if across.any():
        now, then = (
            _covered(cells, left[across], right[across]) for left, right in (after, before)
        )
        np.add.at(change, rows.row[across], (now - then) * np.float32(1 / FINE / step))
    return change


def _covered(cells: Cells, left: Array, right: Array) -> NDArray[np.float32]:
    """Give the part of each cell from left to right (rows,): (rows, columns)."""
    # From the first column on, that single precision suffices.
    first = np.arange(cells.shape[1], dtype=np.float32)
    found, at_left = (
        ((edge - cells.left) * cells.fine).astype(np.float32)[:, None] - first
        for edge in (right, left)
    )
    for part in (found, at_left):
        np.minimum(part, 1, out=part)
        np.maximum(part, 0, out=part)
    found -= at_left
    return found
