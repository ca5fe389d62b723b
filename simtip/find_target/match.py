"""A lattice found in an image against the lattice of a target."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from simtip.find_target.grow import Grown
from simtip.geometry import Array
from simtip.target import AsymmetricCircles, Target

FULL_LINE = 0.4
"""Part of a border line's places that has to be there for the line to count."""

COVERAGE = 0.75
"""Part of a target's points that has to be among the candidates."""

STRAY = 0.1
"""Most points of the lattice, as part of the target's, where the target has none."""

WHOLE = 0.85
"""Least part of the points that a lattice has whose size is told."""


@dataclass(frozen=True, eq=False)
class Reading:
    """One way to read a lattice as the target.

    Attributes
    ----------
    ids, pixels
        (n,) points of the target, ascending, and (n, 2) where candidates for them are.
    mirrored
        Whether this reading shows the target in a mirror.
    upright
        From -1 to 1: how well x runs to the right and y down in the image.
    """

    ids: NDArray[np.intp]
    pixels: Array
    mirrored: bool
    upright: float


def readings(target: Target, grown: Grown) -> list[Reading]:
    """Give all ways to read a lattice as the target, the most upright first."""
    hand = _hand(grown)
    size = target.lattice.max(axis=0) + 1
    ids = {(int(x), int(y)): k for k, (x, y) in enumerate(target.lattice)}
    found: dict[bytes, Reading] = {}
    for way in _best_ways(target, grown):
        if (way.span != size).any():
            continue
        chosen = np.array([ids.get((int(x), int(y)), -1) for x, y in way.places])
        inside = chosen >= 0
        if np.count_nonzero(inside) < COVERAGE * len(ids):
            continue
        if len(grown.places) - np.count_nonzero(inside) > STRAY * len(ids):
            continue
        order = np.argsort(chosen[inside])
        at, pixels = chosen[inside][order], grown.pixels[way.kept[inside][order]]
        mirrored = bool(hand * np.linalg.det(way.matrix) < 0)
        slopes = _slopes(target.lattice[at], pixels)
        reading = Reading(at, pixels, mirrored, _upright(slopes))
        found.setdefault(at.tobytes() + pixels.tobytes(), reading)
    return sorted(found.values(), key=lambda r: -r.upright)


def extent(target: Target, grown: Grown) -> tuple[int, int] | None:
    """Say how many columns and rows a lattice has, as the target counts; None if it has holes.

    The larger number comes first if the target's does, for an image does not tell.
    """
    sizes = []
    for way in _best_ways(target, grown):
        columns, rows = (int(n) for n in way.span)
        if isinstance(target, AsymmetricCircles):
            columns = (columns + 1) // 2
        if min(columns, rows) >= 2:
            sizes.append((abs(len(way.places) / (columns * rows) - 1), columns, rows))
    if not sizes or min(sizes)[0] > 1 - WHOLE:
        return None
    _, columns, rows = min(sizes)
    wide = target.lattice[:, 0].max() >= target.lattice[:, 1].max()
    if (columns >= rows) != wide and not isinstance(target, AsymmetricCircles):
        columns, rows = rows, columns
    return columns, rows


def _hand(grown: Grown) -> float:
    """Give the sign of the turn from the first to the second direction, as seen in the image."""
    return float(np.sign(np.linalg.det(_slopes(grown.places, grown.pixels))))


def _matrices(target: Target) -> list[NDArray[np.intp]]:
    """Give all ways to name the two steps of a lattice, which may be found along a diagonal."""
    numbers = np.array(list(product((-1, 0, 1), repeat=4)), dtype=np.intp).reshape(-1, 2, 2)
    det = numbers[:, 0, 0] * numbers[:, 1, 1] - numbers[:, 0, 1] * numbers[:, 1, 0]
    # Straight ones before skewed ones: the first of equals wins.
    plain = np.abs(numbers).sum(axis=(1, 2))
    ways = [numbers[k] for k in np.argsort(plain, kind="stable") if abs(det[k]) == 1]
    if isinstance(target, AsymmetricCircles):
        diagonal = np.array([[1, 1], [1, -1]], dtype=np.intp)
        return [diagonal @ m for m in ways]
    return ways


@dataclass(frozen=True, eq=False)
class _Way:
    """A lattice with its steps named: its places from 0, which were kept, and how full its box."""

    matrix: NDArray[np.intp]
    places: NDArray[np.intp]
    kept: NDArray[np.intp]
    fill: float

    @property
    def span(self) -> NDArray[np.intp]:
        """(2,) columns and rows of the box."""
        span: NDArray[np.intp] = self.places.max(axis=0) + 1
        return span


def _best_ways(target: Target, grown: Grown) -> list[_Way]:
    """Give those ways to name the steps that fill their box best: others are skewed."""
    ways = []
    for matrix in _matrices(target):
        places, kept = _trimmed(grown.places @ matrix.T, target)
        if len(places):
            box = float(np.prod(places.max(axis=0) + 1)) * _per_place(target)
            ways.append(_Way(matrix, places, kept, len(places) / box))
    scores = [len(way.places) * way.fill for way in ways]
    return [way for way, s in zip(ways, scores, strict=True) if s > 0.99 * max(scores)]


def _per_place(target: Target) -> float:
    """Give the part of the lattice's places that hold a point."""
    return 0.5 if isinstance(target, AsymmetricCircles) else 1.0


def _trimmed(places: NDArray[np.intp], target: Target) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Drop border lines that are mostly empty; begin at 0. Gives places and which were kept."""
    kept = np.arange(len(places))
    while len(kept):
        low, high = places[kept].min(axis=0), places[kept].max(axis=0)
        span = high - low + 1
        worst, line = 1.0, None
        for axis in (0, 1):
            expected = max(1.0, span[1 - axis] * _per_place(target))
            for end in (low[axis], high[axis]):
                full = np.count_nonzero(places[kept, axis] == end) / expected
                if full < worst:
                    worst, line = full, (axis, end)
        if line is None or worst >= FULL_LINE:
            return places[kept] - low, kept
        kept = kept[places[kept, line[0]] != line[1]]
    return places[kept], kept


def _slopes(places: NDArray[np.intp], pixels: Array) -> Array:
    """Give the mean (2, 2) step in the image along x and along y."""
    x = places - places.mean(axis=0)
    return np.asarray(np.linalg.lstsq(x, pixels - pixels.mean(axis=0), rcond=None)[0])


def _upright(slopes: Array) -> float:
    lengths = np.linalg.norm(slopes, axis=1)
    return float((slopes[0, 0] / lengths[0] + slopes[1, 1] / lengths[1]) / 2)
