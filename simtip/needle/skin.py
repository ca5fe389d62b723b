"""The surface at a ball's radius from a polyhedral front: facets, rolled edges, round corners.

The rounded front is the union of the balls of radius r about the points of an inner front, whose
planes and rims lie r inside those of the sharp one. So its surface is known exactly: each facet
moves out by r, along each edge runs a strip whose normals turn from one facet to the next (or to
the cylinder), and each corner becomes a piece of a sphere. Every vertex made here lies on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array, unit
from simtip.needle.planes import Facets, Planes
from simtip.needle.tip import Faces

Key = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Skin:
    """Vertices (n, 3) mm and outward faces (m, 3); the first `Facets.rims` vertices are the rims.

    On a rim lies where the surface meets the cylinder, whose normal is radial there.
    """

    vertices: Array
    faces: Faces


def skin(facets: Facets, planes: Planes, r: float, steps: int, ahead: NDArray[np.int64]) -> Skin:
    """Build the surface at distance `r` from a front.

    Parameters
    ----------
    facets
        The inner front.
    planes
        Its planes.
    r
        Radius of the ball, mm; 0 gives the front itself.
    steps
        Chords to an arc.
    ahead
        Points of the front that are foremost: the ball's foremost point becomes a vertex there.
    """
    return _Builder(facets, planes, r, steps, {int(p) for p in ahead}).build()


class _Builder:
    """Numbers vertices as (point of the front, label of a normal): a plane's, or the rim's."""

    def __init__(
        self, facets: Facets, planes: Planes, r: float, steps: int, ahead: set[int]
    ) -> None:
        self.facets, self.planes, self.r, self.steps, self.ahead = facets, planes, r, steps, ahead
        self.normals = planes.normals
        self.rim = len(self.normals)
        angles = facets.angles
        out = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)
        self.rim_normals = np.concatenate([out, -out])
        self.vertices = [facets.points[: facets.rims] + r * self.rim_normals[: facets.rims]]
        self.count = facets.rims
        self.corner: dict[tuple[int, int], int] = {}
        self.faces: list[Faces] = []
        self.side = {
            (int(i), int(j)): f
            for f, (_, ids) in enumerate(facets.polygons)
            for i, j in zip(ids, np.roll(ids, -1), strict=True)
        }
        self.leaving = {(i, f): j for (i, j), f in self.side.items()}
        # The facet whose edge along the rim ends at a point.
        self.ending = {j: f for (i, j), f in self.side.items() if (j, i) not in self.side}
        self.around = {p: self._cycle(p, f) for (p, _), f in self.side.items()} if r > 0 else {}
        self.arcs: dict[Key, NDArray[np.int64]] = {}

    def build(self) -> Skin:
        """Lay the facets, roll the edges, round the corners."""
        if self.r == 0:
            self._add(self.facets.points[self.facets.rims :])
        self._lay_facets()
        if self.r > 0:
            self._roll_edges()
            self._round_corners()
        return Skin(np.concatenate(self.vertices), np.concatenate(self.faces))

    def _add(self, points: Array) -> NDArray[np.int64]:
        ids = np.arange(self.count, self.count + len(points))
        self.vertices.append(points)
        self.count += len(points)
        return ids

    def _normal(self, point: int, label: int) -> Array:
        normal: Array = self.rim_normals[point] if label == self.rim else self.normals[label]
        return normal

    def _corners(self, ids: NDArray[np.int64], plane: int) -> NDArray[np.int64]:
        """Give the vertices of a facet's corners."""
        if self.r == 0:
            return ids
        new = [int(p) for p in ids if (int(p), plane) not in self.corner]
        made = self._add(self.facets.points[new] + self.r * self.normals[plane])
        self.corner.update({(p, plane): int(v) for p, v in zip(new, made, strict=True)})
        return np.array([self.corner[int(p), plane] for p in ids])

    def _lay_facets(self) -> None:
        for plane, ids in self.facets.polygons:
            around = self._corners(ids, plane)
            if len(ids) <= 4:
                fan = [(around[0], around[k + 1], around[k]) for k in range(1, len(ids) - 1)]
                self.faces.append(np.array(fan))
                continue
            centre = self._centre(plane, ids) + self.r * self.normals[plane]
            middle = np.full(len(ids), self._add(centre[None])[0])
            self.faces.append(np.stack([middle, np.roll(around, -1), around], axis=1))

    def _centre(self, plane: int, ids: NDArray[np.int64]) -> Array:
        """Give a point well inside a facet: on the axis, if that is."""
        corners = self.facets.points[ids]
        x, y = corners[:, 0], corners[:, 1]
        left = x * np.roll(y, -1) - y * np.roll(x, -1)  # of each edge seen from the axis
        if (left > 1e-3 * np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y) * np.hypot(x, y)).all():
            return np.array([0.0, 0.0, self.planes.heights(np.zeros((1, 2)))[plane, 0]])
        mean: Array = corners.mean(axis=0)
        return mean

    def _neighbour(self, i: int, j: int) -> int:
        """Give the label beyond the edge i j of a facet."""
        other = self.side.get((j, i))
        return self.rim if other is None else self.facets.polygons[other][0]

    def _roll_edges(self) -> None:
        strips = []
        for (i, j), f in self.side.items():
            plane, beyond = self.facets.polygons[f][0], self._neighbour(i, j)
            if plane < beyond:  # each crease once; the rim's label is the largest
                strips.append((i, j, plane, beyond))
        keys = list(dict.fromkeys((p, k, m) for i, j, k, m in strips for p in (i, j)))
        rows = self._arcs(keys)
        self.arcs = dict(zip(keys, rows, strict=True))
        a = np.array([self.arcs[i, k, m] for i, _, k, m in strips])
        b = np.array([self.arcs[j, k, m] for _, j, k, m in strips])
        first = np.stack([a[:, :-1], b[:, :-1], b[:, 1:]], axis=-1)
        second = np.stack([a[:, :-1], b[:, 1:], a[:, 1:]], axis=-1)
        self.faces += [first.reshape(-1, 3), second.reshape(-1, 3)]

    def _arcs(self, keys: list[Key]) -> NDArray[np.int64]:
        """Give the vertices (n, steps + 1) of arcs between two normals at a point."""
        start = np.array([self._normal(p, k) for p, k, _ in keys])
        end = np.array([self._normal(p, m) for p, _, m in keys])
        at_rim = np.array([m == self.rim for _, _, m in keys])
        share = np.where(at_rim[:, None], self._rim_shares(keys), np.linspace(0, 1, self.steps + 1))
        turned = _slerp(start, end, share[:, 1:-1])
        points = self.facets.points[[p for p, _, _ in keys]]
        inner = self._add((points[:, None] + self.r * turned).reshape(-1, 3))
        rows = np.empty((len(keys), self.steps + 1), dtype=np.int64)
        rows[:, 1:-1] = inner.reshape(len(keys), -1)
        rows[:, 0] = [self.corner[p, k] for p, k, _ in keys]
        rows[:, -1] = [p if m == self.rim else self.corner[p, m] for p, _, m in keys]
        return rows

    def _rim_shares(self, keys: list[Key]) -> Array:
        """Give the shares of the rim's arcs, among them straight ahead at the foremost point."""
        shares = np.linspace(0, 1, self.steps + 1)
        for p, k, m in keys:
            if m == self.rim and p in self.ahead and len(self.around[p]) == 2:
                start, end = self._normal(p, k), self._normal(p, m)
                split = float(np.arccos(-start[2]) / np.arccos(np.clip(start @ end, -1, 1)))
                before = min(max(round(split * self.steps), 1), self.steps - 1)
                shares = np.concatenate(
                    [
                        np.linspace(0, split, before + 1),
                        np.linspace(split, 1, self.steps - before + 1)[1:],
                    ]
                )
        return shares

    def _cycle(self, point: int, start: int) -> list[int]:
        """Give the labels of the normals around a point, clockwise seen from the hub."""
        labels: list[int] = []
        face = start
        for _ in self.facets.polygons:  # at most all of them meet at the point
            labels.append(self.facets.polygons[face][0])
            other = self.side.get((self.leaving[point, face], point))
            if other is None:
                labels.append(self.rim)
                other = self.ending[point]
            face = other
            if face == start:
                break
        return [k for n, k in enumerate(labels) if k != labels[n - 1]]

    def _round_corners(self) -> None:
        for point, labels in self.around.items():
            if len(labels) < 3:
                continue
            normals = np.array([self._normal(point, k) for k in labels])
            centre = np.array([0, 0, -1.0]) if point in self.ahead else unit(normals.sum(axis=0))
            middle = int(self._add((self.facets.points[point] + self.r * centre)[None])[0])
            spokes = [self._spoke(point, k, centre, middle) for k in labels]
            for n, (k, m) in enumerate(zip(labels, labels[1:] + labels[:1], strict=True)):
                outer = self.arcs[point, k, m] if k < m else self.arcs[point, m, k][::-1]
                self._fill(point, spokes[n], spokes[(n + 1) % len(spokes)], outer)

    def _spoke(self, point: int, label: int, centre: Array, middle: int) -> NDArray[np.int64]:
        """Make the arc from a corner's centre to one of its normals."""
        share = np.linspace(0, 1, self.steps + 1)[None, 1:-1]
        turned = _slerp(centre[None], self._normal(point, label)[None], share)[0]
        inner = self._add(self.facets.points[point] + self.r * turned)
        end = point if label == self.rim else self.corner[point, label]
        return np.concatenate([[middle], inner, [end]])

    def _fill(
        self,
        point: int,
        left: NDArray[np.int64],
        right: NDArray[np.int64],
        outer: NDArray[np.int64],
    ) -> None:
        """Fill a spherical triangle between three arcs, row by row."""
        vertices = np.concatenate(self.vertices)
        about = self.facets.points[point]
        rows = [left[:1]]
        for n in range(1, self.steps):
            ends = (vertices[[left[n], right[n]]] - about) / self.r
            turned = _slerp(ends[:1], ends[1:], (np.arange(1, n) / n)[None])[0]
            inner = self._add(about + self.r * turned)
            rows.append(np.concatenate([[left[n]], inner, [right[n]]]))
        rows.append(outer)
        for upper, lower in pairwise(rows):
            self.faces.append(np.stack([upper, lower[:-1], lower[1:]], axis=1))
            self.faces.append(np.stack([upper[:-1], lower[1:-1], upper[1:]], axis=1))


def _slerp(start: Array, end: Array, share: Array) -> Array:
    """Turn unit vectors (n, 3) towards others by shares (n, m) of the angle: (n, m, 3)."""
    cross = np.linalg.norm(np.cross(start, end), axis=1)
    angle = np.arctan2(cross, (start * end).sum(axis=1))[:, None]
    small = angle < 1e-9
    sine = np.where(small, 1.0, np.sin(angle))
    first = np.where(small, 1 - share, np.sin((1 - share) * angle) / sine)
    second = np.where(small, share, np.sin(share * angle) / sine)
    turned = first[..., None] * start[:, None] + second[..., None] * end[:, None]
    return np.asarray(turned / np.linalg.norm(turned, axis=-1, keepdims=True))
