"""How much of each texel a polygon covers, exactly.

Each piece of the outline adds, in the texel it crosses, the signed area to its right, and to all
texels further right its height; a running sum over the row then is the covered area (the signed
area accumulation by which font renderers draw). So a speck far smaller than a texel has its area.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array

BAND = 32
"""Rows that share a patch: a long diagonal line then needs little more than its own texels."""


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of a polygon's coverage: `share` (h, w), 0 to 1, from texel (row, col) on."""

    row: int
    col: int
    share: Array


def coverage(polygon: Array) -> Iterator[Patch]:
    """Give the coverage of a polygon, in bands of rows.

    Parameters
    ----------
    polygon
        (n, 2) corners (x, y) in texel units: texel (j, i) is [i, i+1) x [j, j+1). The outline must
        not cross itself; where it does, parts that wind twice count as covered.
    """
    row, col, value = _strokes(polygon)
    band = row // BAND
    order = np.argsort(band, kind="stable")
    row, col, value, band = row[order], col[order], value[order], band[order]
    cuts = np.flatnonzero(np.diff(band)) + 1
    starts, ends = [0, *cuts], [*cuts, len(band)]
    for start, end in zip(starts, ends, strict=True):
        yield _patch(row[start:end], col[start:end], value[start:end])


def area(polygon: Array) -> float:
    """Give a polygon's signed area (shoelace), in the square of its unit."""
    x, y = (polygon - polygon[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)


def _patch(row: NDArray[np.int64], col: NDArray[np.int64], value: Array) -> Patch:
    top, left = int(row.min()), int(col.min())
    height, width = int(row.max()) - top + 1, int(col.max()) - left + 1
    flat = np.bincount((row - top) * width + col - left, value, minlength=height * width)
    summed = np.abs(np.cumsum(flat.reshape(height, width), axis=1))
    return Patch(top, left, np.minimum(summed, 1.0))


def _strokes(polygon: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Cut the outline at the texels' borders: row, column and what each piece adds there."""
    a, b = _within_cells(*_short(polygon, np.roll(polygon, -1, axis=0)))
    middle = (a + b) / 2
    cell = np.floor(middle)
    height = b[:, 1] - a[:, 1]
    left_part = height * (middle[:, 0] - cell[:, 0])
    col, row = cell.astype(np.int64).T
    return (
        np.concatenate([row, row]),
        np.concatenate([col, col + 1]),
        np.concatenate([height - left_part, left_part]),
    )


def _short(start: Array, end: Array) -> tuple[Array, Array]:
    """Split edges (n, 2) into pieces no longer than a texel along either axis."""
    pieces = np.maximum(np.ceil(np.abs(end - start).max(axis=1)), 1).astype(np.int64)
    which = np.repeat(np.arange(len(start)), pieces)
    turn = np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    t = (turn / pieces[which])[:, None]
    after = ((turn + 1) / pieces[which])[:, None]
    edge = (end - start)[which]
    return start[which] + t * edge, start[which] + after * edge


def _within_cells(a: Array, b: Array) -> tuple[Array, Array]:
    """Cut pieces (n, 2), which meet at most one line of each direction inside, at those lines."""
    line = np.ceil(np.minimum(a, b))
    step = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(step != 0, (line - a) / step, 1.0)
    t = np.sort(np.clip(t, 0.0, 1.0), axis=1)
    knots = [a, a + t[:, :1] * step, a + t[:, 1:] * step, b]
    return np.concatenate(knots[:-1]), np.concatenate(knots[1:])
