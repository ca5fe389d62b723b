"""A needle bent to an arc: the map from the straight one, and a mesh cut finely enough for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.needle.tip import Faces

ON_LEVEL_MM = 1e-9


@dataclass(frozen=True)
class Bend:
    """The axis becomes an arc that leaves the tip along +z; cross-sections stay flat and round.

    A point (x, y, s) of the straight needle goes to where its cross-section is at arc length s.
    So the foremost plane, z = 0, and the tip in it stay where they are.

    Attributes
    ----------
    radius_mm
        Of the axis.
    direction_deg
        Azimuth in the needle's frame towards which the hub bends.
    """

    radius_mm: float
    direction_deg: float

    @property
    def _towards(self) -> Array:
        angle = math.radians(self.direction_deg)
        return np.array([math.cos(angle), math.sin(angle)])

    def apply(self, points: ArrayLike) -> Array:
        """Map points (..., 3), mm, of the straight needle to the bent one."""
        p = np.array(points, dtype=np.float64)
        across = p[..., :2] @ self._towards
        turn = p[..., 2] / self.radius_mm
        inward = 2 * (self.radius_mm - across) * np.sin(turn / 2) ** 2
        p[..., 2] = (self.radius_mm - across) * np.sin(turn)
        p[..., :2] += inward[..., None] * self._towards
        return p

    def undo(self, points: ArrayLike) -> Array:
        """Map points (..., 3), mm, of the bent needle, up to half a turn, to the straight one."""
        p = np.array(points, dtype=np.float64)
        off = self.radius_mm - p[..., :2] @ self._towards
        p[..., :2] += (off - np.hypot(off, p[..., 2]))[..., None] * self._towards
        p[..., 2] = self.radius_mm * np.arctan2(p[..., 2], off)
        return p

    def levels(self, length_mm: float, half_width_mm: float, sagitta_mm: float) -> Array:
        """Give arc lengths from 0 to the end, between which chords keep to a sagitta."""
        step = self.radius_mm * math.sqrt(8 * sagitta_mm / (self.radius_mm + half_width_mm))
        return np.linspace(0, length_mm, max(math.ceil(length_mm / step), 1) + 1)


def cut_at_levels(vertices: Array, faces: Faces, levels: Array) -> tuple[Array, Faces]:
    """Divide faces along planes z = level, so that none reaches across one.

    New vertices, on edges that reached across, follow the old ones. The middle level comes first,
    then the middles of the halves: from end to end each cut would cut the last one's pieces again.
    """
    if not len(levels):
        return vertices, faces
    middle = len(levels) // 2
    vertices, faces = _cut(vertices, faces, float(levels[middle]))
    vertices, faces = cut_at_levels(vertices, faces, levels[:middle])
    return cut_at_levels(vertices, faces, levels[middle + 1 :])


def _cut(vertices: Array, faces: Faces, level: float) -> tuple[Array, Faces]:
    height = vertices[:, 2] - level
    side = np.where(np.abs(height) < ON_LEVEL_MM, 0, np.sign(height)).astype(np.int64)
    of_face = side[faces]
    across = (of_face.min(axis=1) < 0) & (of_face.max(axis=1) > 0)
    if not across.any():
        return vertices, faces
    kept, parted, of_face = faces[~across], faces[across], of_face[across]
    # Turn each face so that the corner that lies alone on its side, or on the level, comes first.
    touching = (of_face == 0).any(axis=1)
    alone = np.where(touching, 0, -np.sign(of_face.sum(axis=1)))
    first = (of_face == alone[:, None]).argmax(axis=1)
    a, b, c = (
        np.take_along_axis(parted, ((first + k) % 3)[:, None], axis=1)[:, 0] for k in range(3)
    )
    edges = np.concatenate(
        [
            np.stack([b[touching], c[touching]], axis=1),
            np.stack([a[~touching], b[~touching]], axis=1),
            np.stack([a[~touching], c[~touching]], axis=1),
        ]
    )
    vertices, middle = _with_middles(vertices, np.sort(edges, axis=1), height, level)
    t, n = int(touching.sum()), int((~touching).sum())
    opposite, on_ab, on_ac = middle[:t], middle[t : t + n], middle[t + n :]
    at, bt, ct = a[touching], b[touching], c[touching]
    a, b, c = a[~touching], b[~touching], c[~touching]
    pieces = [
        kept,
        np.stack([at, bt, opposite], axis=1),
        np.stack([at, opposite, ct], axis=1),
        np.stack([a, on_ab, on_ac], axis=1),
        np.stack([on_ab, b, c], axis=1),
        np.stack([on_ab, c, on_ac], axis=1),
    ]
    return vertices, np.concatenate(pieces)


def _with_middles(
    vertices: Array, edges: Faces, height: Array, level: float
) -> tuple[Array, NDArray[np.int64]]:
    """Add the points where edges meet a level, one for each edge; give each edge's."""
    edges, which = np.unique(edges, axis=0, return_inverse=True)
    i, j = edges.T
    share = (height[i] / (height[i] - height[j]))[:, None]
    points = vertices[i] + share * (vertices[j] - vertices[i])
    points[:, 2] = level
    return np.concatenate([vertices, points]), len(vertices) + which.reshape(-1)
