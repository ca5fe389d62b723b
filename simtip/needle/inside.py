"""What a closed surface holds, and what it hides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.needle.tip import Faces


def encloses(vertices: Array, faces: Faces, point: Array) -> bool:
    """Say whether a closed, outward surface encloses a point (3,).

    The solid angle of all faces, signed, seen from the point, is 4 pi inside and 0 outside
    (van Oosterom and Strackee 1983, doi 10.1109/TBME.1983.325207).
    """
    corners = (vertices - point)[faces]
    length = np.linalg.norm(corners, axis=2)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = length.T
    volume = (a * np.cross(b, c)).sum(axis=1)
    below = (
        la * lb * lc
        + (a * b).sum(axis=1) * lc
        + (b * c).sum(axis=1) * la
        + (c * a).sum(axis=1) * lb
    )
    return bool(2 * np.arctan2(volume, below).sum() > 2 * np.pi)


def hides(vertices: Array, faces: Faces, tip: NDArray[np.int64], centre: Array) -> bool:
    """Say whether a solid hides its own tip, a convex one, from a centre (3,) outside.

    It does if all faces at the tip are turned away, or if another face lies in between.

    Parameters
    ----------
    vertices, faces
        The closed, outward surface.
    tip
        Vertices of the tip, the foremost first: one, or those of the ball that rounds it.
    centre
        Where it is looked at from.
    """
    at_tip = np.isin(faces, tip).any(axis=1)
    a, b, c = (vertices[faces[at_tip][:, k]] for k in range(3))
    turned_to = (np.cross(b - a, c - a) * (centre - a)).sum(axis=1) > 0
    if not turned_to.any():
        return True
    seen = tip[np.isin(tip, faces[at_tip][turned_to])]
    return _is_crossed(vertices, faces[~at_tip], centre, vertices[seen[0]])


def _is_crossed(vertices: Array, faces: Faces, start: Array, end: Array) -> bool:
    """Say whether faces cross the way between two points (Moeller and Trumbore 1997)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    along = end - start
    ab, ac, off = b - a, c - a, start - a
    p = np.cross(along, ac)
    det = (ab * p).sum(axis=1)
    q = np.cross(off, ab)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (off * p).sum(axis=1) / det
        v = (q @ along) / det
        t = (ac * q).sum(axis=1) / det
        return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1 - 1e-9)).any())
