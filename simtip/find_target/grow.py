"""Candidates joined to lattices: from a seed of four outwards, each place predicted by the last."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from simtip.find_target.candidates import Candidates
from simtip.geometry import Array

SEED_TOLERANCE, TOLERANCE = 0.3, 0.28
"""How far a candidate may lie from where it is expected, in steps."""

SEED_NEIGHBOURS = 12

SEEDS = 600
"""Seeds that are tried at most."""

LEAST = 6
"""Points of a lattice that is worth to be told of, if the target does not have fewer."""

SQUAREST = 0.3
"""Least sine of the angle between the two steps of a seed."""

ENOUGH, MOST_OF = 3, 0.75
"""How many lattices of so large a part of the target's points end the search."""


@dataclass(frozen=True, eq=False)
class Grown:
    """A lattice found among candidates.

    Attributes
    ----------
    places
        (n, 2) whole numbers; which step is x and where it begins is not known yet.
    pixels
        (n, 2) u, v.
    """

    places: NDArray[np.intp]
    pixels: Array


def grow(candidates: Candidates, wanted: int) -> list[Grown]:
    """Find lattices, the largest first, until some have most of the points that are wanted."""
    found: list[Grown] = []
    least = min(LEAST, wanted)
    if len(candidates.pixels) < least:
        return found
    tree = cKDTree(candidates.pixels)
    used = np.zeros(len(candidates.pixels), dtype=np.bool_)
    for seed in range(min(SEEDS, len(used))):
        if used[seed]:
            continue
        steps = _seed_steps(candidates, tree, seed)
        if steps is None:
            continue
        placed = _spread(candidates, tree, seed, *steps)
        if len(placed) < least:
            continue
        ids = np.array(list(placed.values()))
        used[ids] = True
        places = np.array(list(placed), dtype=np.intp)
        found.append(Grown(places, candidates.pixels[ids]))
        if sum(len(grown.places) >= MOST_OF * wanted for grown in found) >= ENOUGH:
            break
    return sorted(found, key=lambda g: -len(g.places))


def _seed_steps(candidates: Candidates, tree: cKDTree, seed: int) -> tuple[Array, Array] | None:
    """Give two steps from a candidate to neighbours that close a parallelogram."""
    pixels = candidates.pixels
    nearest = tree.query(pixels[seed], k=min(SEED_NEIGHBOURS + 1, len(pixels)))[1]
    near = np.asarray(nearest)[1:]
    near = near[candidates.may_be_neighbours(seed, near)]
    away = pixels[near] - pixels[seed]
    length = np.linalg.norm(away, axis=1)
    for i in range(min(4, len(near))):
        for j in range(i + 1, len(near)):
            cross = away[i, 0] * away[j, 1] - away[i, 1] * away[j, 0]
            if abs(cross) < SQUAREST * length[i] * length[j]:
                continue
            gap, _ = tree.query(pixels[seed] + away[i] + away[j])
            if gap < SEED_TOLERANCE * length[i]:
                return away[i], away[j]
            break
    return None


def _spread(
    candidates: Candidates, tree: cKDTree, seed: int, right: Array, down: Array
) -> dict[tuple[int, int], int]:
    """Place candidates around a seed, the nearest places first."""
    pixels = candidates.pixels
    placed = {(0, 0): seed}
    taken = {seed}
    steps = {(0, 0): (right, down)}
    waiting = deque([(0, 0)])
    while waiting:
        here = waiting.popleft()
        for axis in (0, 1):
            for sign in (1, -1):
                there = (here[0] + sign, here[1]) if axis == 0 else (here[0], here[1] + sign)
                if there in placed:
                    continue
                step = sign * steps[here][axis]
                shortest = min(np.hypot(*steps[here][0]), np.hypot(*steps[here][1]))
                gap, k = tree.query(pixels[placed[here]] + step)
                if gap > TOLERANCE * min(np.hypot(*step), 1.5 * shortest) or int(k) in taken:
                    continue
                if not candidates.may_be_neighbours(placed[here], np.array([k]))[0]:
                    continue
                placed[there] = int(k)
                taken.add(int(k))
                moved = sign * (pixels[k] - pixels[placed[here]])
                old = steps[here]
                steps[there] = (moved, old[1]) if axis == 0 else (old[0], moved)
                waiting.append(there)
    return placed
