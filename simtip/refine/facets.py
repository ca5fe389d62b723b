"""The planes ground into a tip: each is lit in its own, even way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array

FORWARD = 0.02
"""Least sine of the angle between the axis and a face of the tip; the shaft's have none."""

FLAT_RAD, FLAT_SHARE = 2e-3, 1e-3
"""Faces of one plane differ by less in direction, and in distance by less of the radius."""

LEAST_SHARE = 0.1
"""Of the shaft's cross-section: smaller planes are edges, or parts of a curve."""

MOST = 8
"""More planes than this are a curve, in facets."""

CANDIDATES = 32
"""Faces that are tried, the largest first."""


@dataclass(frozen=True, eq=False)
class Facet:
    """A convex planar part of the surface.

    Attributes
    ----------
    normal
        (3,) unit, outward.
    corners
        (n, 3) mm, points whose convex hull it is.
    """

    normal: Array
    corners: Array


def forward(points: Array, faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which faces (k, 3) of a mesh look forward, as the tip's do and the shaft's do not."""
    normal, area = _normals(points, faces)
    return np.asarray((normal[:, 2] < -FORWARD) & (area > 0))


def planar(
    points: Array, faces: NDArray[np.int64], radius_mm: float
) -> tuple[tuple[Facet, ...], float]:
    """Find the planes among faces.

    Parameters
    ----------
    points, faces
        (n, 3) mm, and (k, 3) outward triangles.
    radius_mm
        Of the shaft.

    Returns
    -------
    facets, curved
        The planes, and the share of the faces' area that lies in none.
    """
    normal, area = _normals(points, faces)
    away = np.einsum("ij,ij->i", normal, points[faces].mean(axis=1))
    free = np.ones(len(faces), np.bool_)
    found = []
    for k in np.argsort(-area, kind="stable")[:CANDIDATES]:
        if not free[k]:
            continue
        turn = np.linalg.norm(normal - normal[k], axis=1)
        same = free & (turn < FLAT_RAD) & (np.abs(away - away[k]) < FLAT_SHARE * radius_mm)
        if area[same].sum() < LEAST_SHARE * np.pi * radius_mm**2:
            continue
        free &= ~same
        found.append(Facet(normal[k], points[np.unique(faces[same])]))
    if len(found) > MOST:
        return (), 1.0
    return tuple(found), float(area[free].sum() / max(area.sum(), 1e-300))


def _normals(points: Array, faces: NDArray[np.int64]) -> tuple[Array, Array]:
    a, b, c = (points[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(double, 1e-300)[:, None], double / 2
