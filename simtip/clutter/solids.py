"""Closed meshes: bent tubes and ellipsoids, faces outward."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array, unit

Faces = NDArray[np.int64]

SIDES = 24
"""Of a tube's polygon; its corners lie on the circle, so it is thin by 0.9 % of the radius."""


def tube(spine: Array, radii: Array, sides: int = SIDES) -> tuple[Array, Faces]:
    """Build a round tube about a smooth curve, closed by flat ends.

    Parameters
    ----------
    spine
        (n, 3) points, mm, n at least 2, no two neighbours equal.
    radii
        (n,) mm, above 0.
    sides
        Corners of each ring.

    Returns
    -------
    vertices
        (n sides + 2, 3): the rings in the spine's order, then the ends' centres.
    faces
        (2 n sides, 3).
    """
    n = len(spine)
    ahead = unit(np.gradient(spine, axis=0))
    across = np.empty_like(ahead)
    across[0] = unit(np.cross(ahead[0], np.eye(3)[np.abs(ahead[0]).argmin()]))
    for k in range(1, n):  # carried along without turning about the spine
        across[k] = unit(across[k - 1] - (across[k - 1] @ ahead[k]) * ahead[k])
    up = np.cross(ahead, across)
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = (
        np.cos(angle)[:, None] * across[:, None, :] + np.sin(angle)[:, None] * up[:, None, :]
    ) * radii[:, None, None] + spine[:, None, :]
    vertices = np.concatenate([rings.reshape(-1, 3), spine[[0, -1]]])
    here = np.arange(sides)
    after = np.roll(here, -1)
    base = sides * np.arange(n - 1)[:, None]
    a, b = (base + here).ravel(), (base + after).ravel()
    first, last = np.full(sides, n * sides), np.full(sides, n * sides + 1)
    end = (n - 1) * sides
    faces = np.concatenate(
        [
            np.stack([a, b, b + sides], axis=1),
            np.stack([a, b + sides, a + sides], axis=1),
            np.stack([first, after, here], axis=1),
            np.stack([last, end + here, end + after], axis=1),
        ]
    )
    return vertices, faces


def ellipsoid(centre: Array, axes: Array) -> tuple[Array, Faces]:
    """Build an ellipsoid (162 vertices on its surface).

    Parameters
    ----------
    centre
        (3,) mm.
    axes
        (3, 3) the semi-axes, mm, as rows of a right-handed frame.
    """
    vertices, faces = _sphere(2)
    return centre + vertices @ axes, faces.copy()


@cache
def _sphere(halvings: int) -> tuple[Array, Faces]:
    """Build the unit sphere from the icosahedron, each edge halved so many times."""
    g = (1 + 5**0.5) / 2
    corners = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0]]
    vertices = unit(np.concatenate([np.roll(corners, k, axis=1) for k in range(3)]))
    gap = np.linalg.norm(vertices[:, None] - vertices, axis=-1)
    near = (gap > 0) & (gap < 1.1)
    faces = np.array(
        [
            (i, j, k)
            for i in range(12)
            for j in range(i + 1, 12)
            for k in range(j + 1, 12)
            if near[i, j] and near[j, k] and near[i, k]
        ]
    )
    for _ in range(halvings):
        vertices, faces = _halved(vertices, faces)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    inward = (np.cross(b - a, c - a) * a).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return vertices, faces


def _halved(vertices: Array, faces: Faces) -> tuple[Array, Faces]:
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(vertices) + which.reshape(-1)).reshape(3, -1)
    a, b, c = faces.T
    middles = unit(vertices[unique].mean(axis=1))
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate(
        [np.stack(corner, axis=1) for corner in quarters]
    )
