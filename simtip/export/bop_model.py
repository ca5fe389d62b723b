"""A needle as a BOP object model: mesh, size, symmetries."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.distance import cdist

from simtip.geometry import Array
from simtip.needle import Blunt, Cone, Diamond, Franseen, Needle, Trocar

FOLDS = {Trocar: 3, Diamond: 4, Franseen: 3}
"""Tips that look the same after a part of a turn, and how many such parts there are."""

BLOCK = 2048
"""Points of which distances to all others are worked out at a time."""


def write_model(path: Path, needle: Needle) -> None:
    """Write the needle's mesh as PLY (ascii, with normals), mm, in the needle's own frame."""
    mesh = needle.mesh()
    data = mesh.export(file_type="ply", encoding="ascii", vertex_normal=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())


def model_info(needle: Needle) -> dict[str, Any]:
    """Give the needle's entry of ``models_info.json``."""
    vertices, _ = needle.surface()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    info = {"diameter": diameter(vertices)}
    info |= {f"min_{axis}": float(value) for axis, value in zip("xyz", low, strict=True)}
    info |= {f"size_{axis}": float(value) for axis, value in zip("xyz", high - low, strict=True)}
    return info | symmetries(needle)


def diameter(points: Array) -> float:
    """Give the largest distance between any two of points (n, 3)."""
    corners = _far_out(points[ConvexHull(points).vertices])
    return max(
        float(cdist(corners[start : start + BLOCK], corners).max())
        for start in range(0, len(corners), BLOCK)
    )


def _far_out(points: Array) -> Array:
    """Leave out points (n, 3) that cannot be an end of the longest distance."""
    start = points[cdist(points[:1], points).argmax()]
    at_least = cdist(start[None], points).max()
    low, high = points.min(axis=0), points.max(axis=0)
    # No point is farther off than the farthest corner of the box around all.
    at_most = np.linalg.norm(np.maximum(points - low, high - points), axis=1)
    kept: Array = points[at_most >= at_least]
    return kept


def symmetries(needle: Needle) -> dict[str, Any]:
    """Give the turns about the axis that leave the needle as it is.

    Bevels have none but the mirror's, which is no motion; nor has anything that is bent.
    """
    if needle.bend is not None:
        return {}
    if isinstance(needle.tip, Cone | Blunt):
        return {"symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}
    count = FOLDS.get(type(needle.tip), 1)
    turns = [_turn(2 * np.pi * k / count) for k in range(1, count)]
    return {"symmetries_discrete": turns} if turns else {}


def _turn(angle: float) -> list[float]:
    """Give the (4, 4) turn about z, row by row."""
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return [float(value) for value in matrix.ravel()]
