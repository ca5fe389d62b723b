"""Random numbers of low discrepancy: Owen-scrambled Sobol points, shifted for every pixel.

One table of points serves all pixels; each pixel, replica and dimension has a digital shift of its
own (an XOR with a hash), which keeps the points' even spread and makes every pixel's estimate
unbiased and independent of its neighbours'. See A. Owen, "Scrambled net variance for integrals of
smooth functions", Ann. Statist. 25 (1997); T. Kollig and A. Keller, "Efficient multidimensional
sampling", Computer Graphics Forum 21 (2002).

Against Mitsuba's multijitter, whose dimensions are stratified in pairs only, the needle took half
as many samples for equal noise, and its edges a third.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.render.chunks import aligned
from simtip.render.engine import dr, mi
from simtip.render.sobol_table import TABLE_POINTS, table

PIXEL, LOBE, APERTURE, LOBE_CHOICE, ROOM, LAMPS = 0, 2, 4, 6, 7, 9
"""First dimension of each use, which names its shifts."""

SCATTERED = 2
"""First column of the table for ways on from a surface: a lobe, the room and every lamp share it.

What they bring is added up, never multiplied, and each has its own shifts, so that their errors
stay uncorrelated. Later columns are worse spread in pairs: up to five times the noise of a lamp
in the needle, for the second of two.
"""

HASH_ROUNDS = 10
"""Of TEA; with four, shifts of neighbours are correlated."""


@cache
def _table() -> NDArray[np.uint32]:
    return aligned(table())


class Points:
    """Sample points of a wavefront: the `index`-th of each owner's sequence.

    Parameters
    ----------
    owners
        Whose shifts count (a pixel and replica, a place on the board): evaluated, one each.
    item
        Which owner, per sample.
    index
        Which point of the sequence, per sample, below TABLE_POINTS.
    seed
        Decides the shifts.
    """

    def __init__(self, owners: Any, item: Any, index: Any, seed: int) -> None:
        self._owners, self._item, self._index = owners, item, index
        self._seed = dr.opaque(mi.UInt32, seed)

    def _at(self, dimension: int, column: int) -> Any:
        points = mi.UInt32(_table()[column])
        name = dr.opaque(mi.UInt32, 0x9E3779B1 * (dimension + 1) % 2**32)
        shift, _ = mi.sample_tea_32(self._owners, self._seed + name, HASH_ROUNDS)
        dr.eval(shift)  # once an owner, not once a sample
        bits = dr.gather(mi.UInt32, points, self._index) ^ dr.gather(mi.UInt32, shift, self._item)
        return mi.Float(bits >> 8) * 2.0**-24

    def _pair(self, dimension: int, column: int) -> Any:
        return mi.Point2f(self._at(dimension, column), self._at(dimension + 1, column + 1))

    def pixel(self) -> Any:
        """Where in the pixel's square."""
        return self._pair(PIXEL, PIXEL)

    def aperture(self) -> Any:
        """Where in the aperture."""
        return self._pair(APERTURE, APERTURE)

    def lobe(self) -> tuple[Any, Any]:
        """Which way a mirror sends the ray: one number and two."""
        return self._at(LOBE_CHOICE, LOBE_CHOICE), self._pair(LOBE, SCATTERED)

    def room(self) -> Any:
        """Which way into the room."""
        return self._pair(ROOM, SCATTERED)

    def lamp(self, k: int) -> Any:
        """Where on emitter `k`."""
        return self._pair(LAMPS + 2 * k, SCATTERED)


def points_of(
    owners: NDArray[np.uint32],
    samples: int,
    seed: int,
    *,
    start: NDArray[np.uint32] | None = None,
) -> tuple[Points, Any]:
    """Give `samples` points of each owner's own sequence, and the owner's place of each sample.

    Who owns a sequence decides its shift, so that nothing depends on how work is cut into pieces.

    Parameters
    ----------
    owners
        (n,).
    samples
        Of each.
    seed
        See `Points`.
    start
        (n,) how many points of each sequence were used before.

    Raises
    ------
    ValueError
        A sequence has no more than TABLE_POINTS points.
    """
    last = samples + (0 if start is None else int(start.max(initial=0)))
    if last > TABLE_POINTS:
        raise ValueError(f"{last} samples: a sequence has {TABLE_POINTS} points")
    count = dr.opaque(mi.UInt32, samples)
    k = dr.arange(mi.UInt32, len(owners) * samples)
    item = k // count
    index = k - item * count
    if start is not None:
        index += dr.gather(mi.UInt32, mi.UInt32(start), item)
    return Points(mi.UInt32(aligned(owners)), item, index, seed), item
