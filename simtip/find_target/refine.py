"""All points of a target to sub-pixel places, from rough ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from simtip.find_target.gray import Gray
from simtip.find_target.local_map import LocalMap, local_maps
from simtip.find_target.register import FIRST_BLUR_PX, Placed, register
from simtip.geometry import Array
from simtip.target import Sighting, Target

LEAST_LIKENESS = 0.7
"""Correlation of image and drawing below which a point counts as not seen."""

UNLIKE = (5.0, 0.02)
"""Most lack of likeness, 1 less the correlation: in medians of all points, and added to those."""

TRIES, ASTRAY = 2, 0.25
"""How often a point is sought next to others, and how far off it may be, in steps."""

SAMPLE = 9
"""Points that decide which of several readings is right."""


def refine(
    target: Target,
    gray: Gray,
    ids: NDArray[np.intp],
    pixels: Array,
    *,
    dark: bool = True,
    passes: int = 2,
) -> Sighting | None:
    """Lay the target's ink over its points; those that do not look like it are left out.

    Parameters
    ----------
    target
        What is seen.
    gray
        (H, W).
    ids, pixels
        (n,) points and (n, 2) their rough places, to a third of a step.
    dark
        Whether the ink is darker than the paper.
    passes
        Each begins with the geometry that the one before found.

    Returns
    -------
    Sighting or None
        None if the places determine no geometry, or fewer than four points are left.
    """
    blur = np.full(len(ids), FIRST_BLUR_PX)
    for _ in range(passes):
        maps = local_maps(target.lattice[ids], pixels)
        if maps is None:
            return None
        placed = [
            register(target, gray, int(k), here, float(b))
            for k, here, b in zip(ids, maps, blur, strict=True)
        ]
        seen = [
            (int(k), p)
            for k, here, p in zip(ids, maps, placed, strict=True)
            if p is not None and _seen(target, int(k), here, p, dark=dark)
        ]
        seen = _alike(seen)
        if len(seen) < 4:
            return None
        ids = np.array([k for k, _ in seen], dtype=np.intp)
        pixels = np.array([p.pixel for _, p in seen])
        blur = np.array([p.blur_px for _, p in seen])
    return Sighting(ids, pixels)


def _seen(target: Target, point: int, here: LocalMap, placed: Placed, *, dark: bool) -> bool:
    expected = here.pixel(target.lattice[point].astype(np.float64))
    likeness = placed.likeness if dark else -placed.likeness
    return likeness >= LEAST_LIKENESS and _near(placed.pixel, expected, here)


def _alike(seen: list[tuple[int, Placed]]) -> list[tuple[int, Placed]]:
    """Leave out points that look much less like the print than most: partly covered ones."""
    if not seen:
        return seen
    unlike = np.array([1 - abs(placed.likeness) for _, placed in seen])
    most = UNLIKE[0] * float(np.median(unlike)) + UNLIKE[1]
    return [pair for pair, u in zip(seen, unlike, strict=True) if u <= most]


def _near(pixel: Array, expected: Array, here: LocalMap) -> bool:
    return bool(np.linalg.norm(pixel - expected) < max(ASTRAY * here.step_px, 1.0))


def likeness(target: Target, gray: Gray, ids: NDArray[np.intp], pixels: Array) -> float:
    """Give the median likeness, -1 to 1, of a few points spread over the target."""
    maps = local_maps(target.lattice[ids], pixels)
    if maps is None:
        return 0.0
    few = np.unique(np.linspace(0, len(ids) - 1, min(SAMPLE, len(ids))).round().astype(np.intp))
    placed = [register(target, gray, int(ids[k]), maps[k]) for k in few]
    return float(np.median([0.0 if p is None else p.likeness for p in placed]))


def with_missing(
    target: Target, ids: NDArray[np.intp], pixels: Array
) -> tuple[NDArray[np.intp], Array]:
    """Add the target's other points where the geometry of their neighbours puts them."""
    missing = np.setdiff1d(np.arange(len(target.lattice)), ids)
    maps = local_maps(target.lattice[ids], pixels) if len(missing) else None
    if maps is None:
        return ids, pixels
    near = np.asarray(cKDTree(target.lattice[ids]).query(target.lattice[missing])[1])
    places = target.lattice[missing].astype(np.float64)
    added = np.array([maps[int(k)].pixel(place) for k, place in zip(near, places, strict=True)])
    there = np.isfinite(added).all(axis=1)
    every = np.concatenate([ids, missing[there]])
    order = np.argsort(every)
    return every[order], np.concatenate([pixels, added[there]])[order]


def spread_out(target: Target, gray: Gray, start: Sighting) -> Sighting:
    """Add points next to those seen, again and again, where they look like the target's ink."""
    seen = {int(k): p for k, p in zip(start.ids, start.pixels, strict=True)}
    tries: dict[int, int] = {}
    inside = np.array(gray.shape[::-1]) - 1
    while True:
        ids = np.array(sorted(seen), dtype=np.intp)
        pixels = np.array([seen[int(k)] for k in ids])
        maps = local_maps(target.lattice[ids], pixels)
        if maps is None:
            return start
        away, near = map(np.asarray, cKDTree(target.lattice[ids]).query(target.lattice))
        added = False
        for point in np.flatnonzero((away > 0) & (away < 1.5)):
            place, here = target.lattice[point].astype(np.float64), maps[int(near[point])]
            tries[int(point)] = tries.get(int(point), 0) + 1
            expected = here.pixel(place)
            if tries[int(point)] > TRIES or not ((expected >= 0) & (expected <= inside)).all():
                continue
            placed = register(target, gray, int(point), here)
            if placed is None or placed.likeness < LEAST_LIKENESS:
                continue
            if _near(placed.pixel, expected, here):
                seen[int(point)] = placed.pixel
                added = True
        if not added:
            return Sighting(ids, pixels)
