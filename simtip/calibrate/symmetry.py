"""In which ways a target's points can be numbered that a plain picture does not tell apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from simtip.geometry import Array
from simtip.target.sighting import Sighting

TOLERANCE = 1e-6
"""How near turned points have to come to points of the target, as a share of its size."""

TURNS_DEG = (0, 180, 90, 270)


def symmetries(points_mm: Array) -> dict[int, NDArray[np.intp]]:
    """Find the turns in its own plane that bring a flat target onto itself.

    Parameters
    ----------
    points_mm
        (n, 3), z = 0.

    Returns
    -------
    dict
        By angle, degrees, the numbering after the turn: (n,), point i lies where point
        ``numbering[i]`` lay. Always holds 0.
    """
    xy = points_mm[:, :2]
    centre = (xy.min(axis=0) + xy.max(axis=0)) / 2
    tree, size = KDTree(xy), float(np.linalg.norm(np.ptp(xy, axis=0)))
    found = {}
    for turn in TURNS_DEG:
        c, s = np.round(np.cos(np.radians(turn))), np.round(np.sin(np.radians(turn)))
        away, numbering = tree.query((xy - centre) @ np.array([[c, s], [-s, c]]) + centre)
        if np.max(away) <= TOLERANCE * size:
            found[turn] = np.asarray(numbering, dtype=np.intp)
    return found


def relabelled(sighting: Sighting, numbering: NDArray[np.intp]) -> Sighting:
    """Give new numbers to the points of a sighting as `numbering` says, ascending again."""
    ids = numbering[sighting.ids]
    order = np.argsort(ids)
    return Sighting(ids[order], sighting.pixels[order])
