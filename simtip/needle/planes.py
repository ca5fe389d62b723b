"""Ground planes, and the front that several of them leave: their upper envelope over a disc."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.needle.tip import on_circle, regular_angles

SAME_ANGLE = 1e-6
"""Where an edge between two planes meets the rim this near to a point of the ring, rad, the two
are one point: less than a nanometre off, and no sliver."""


@dataclass(frozen=True, eq=False)
class Planes:
    """Planes that each leave ``z >= z0 + g . ((x, y) - (x0, y0))`` of the needle.

    Attributes
    ----------
    gradient
        (k, 2), g; the solid lies towards the hub.
    point
        (k, 3) mm, (x0, y0, z0).
    """

    gradient: Array
    point: Array

    @classmethod
    def through(cls, point: ArrayLike, angle: ArrayLike, azimuth: ArrayLike) -> Planes:
        """Make planes from their angle to the axis and the azimuth towards which they rise.

        Parameters
        ----------
        point
            (k, 3) or (3,) mm, a point of each.
        angle
            (k,) rad, between plane and axis.
        azimuth
            (k,) rad, the direction in which the plane runs towards the hub.
        """
        steep, azimuth = 1 / np.tan(np.atleast_1d(angle)), np.atleast_1d(azimuth)
        steep, azimuth = np.broadcast_arrays(steep, azimuth)
        gradient = np.stack([steep * np.cos(azimuth), steep * np.sin(azimuth)], axis=1)
        return cls(gradient, np.broadcast_to(np.asarray(point, float), (len(gradient), 3)))

    @property
    def normals(self) -> Array:
        """(k, 3) unit normals out of the solid."""
        n = np.column_stack([self.gradient, np.full(len(self.gradient), -1.0)])
        outward: Array = n / np.linalg.norm(n, axis=1, keepdims=True)
        return outward

    def heights(self, xy: ArrayLike) -> Array:
        """Give z of each plane over points (n, 2): (k, n) mm."""
        off = np.asarray(xy, float)[None] - self.point[:, None, :2]
        return np.asarray(self.point[:, 2:] + (self.gradient[:, None] * off).sum(axis=2))

    def over(self, xy: ArrayLike) -> Array:
        """Give the front's z over points (n, 2): that of the highest plane."""
        return np.asarray(self.heights(xy).max(axis=0))

    def highest(self, radius_mm: float) -> float:
        """Give the largest z of the front over a disc about the axis."""
        rise = np.linalg.norm(self.gradient, axis=1) * radius_mm
        return float((self.heights(np.zeros((1, 2)))[:, 0] + rise).max())

    def moved(self, along_normal_mm: float, along_z_mm: float = 0.0) -> Planes:
        """Move the planes into the solid, and then along z."""
        steep = np.hypot(1, np.linalg.norm(self.gradient, axis=1))
        point = self.point + np.array([0, 0, 1]) * (along_normal_mm * steep + along_z_mm)[:, None]
        return replace(self, point=point)


@dataclass(frozen=True, eq=False)
class Facets:
    """A polyhedral front over a disc or an annulus.

    Attributes
    ----------
    angles
        (n,) rad, of the rim's points.
    points
        (m, 3) mm: the outer rim's n points, the inner rim's n (an annulus only), inner corners.
    rims
        How many of the points lie on a rim: n or 2 n.
    polygons
        Plane and point indices, counter-clockwise seen from the hub, of each convex piece.
    """

    angles: Array
    points: Array
    rims: int
    polygons: tuple[tuple[int, NDArray[np.int64]], ...]


def facets_over_disc(planes: Planes, radius_mm: float, segments: int) -> Facets:
    """Divide a disc among the planes that are highest there."""
    creases = _creases(planes, radius_mm)
    angles, at = _with_breaks(segments, [angle for angle, _, _ in creases])
    rim, inner = on_circle(angles, radius_mm), _corners(planes, radius_mm)
    xy = np.concatenate([rim, inner])
    heights = planes.heights(xy)
    top = heights.max(axis=0)
    on = heights >= top - 1e-11 * (radius_mm + np.abs(top).max())
    for (_, first, second), index in zip(creases, at, strict=True):
        on[[first, second], index] = True
    polygons = []
    for plane in range(len(heights)):
        ids = np.flatnonzero(on[plane])
        if len(ids) < 3:
            continue
        off = xy[ids] - xy[ids].mean(axis=0)
        ids = ids[np.argsort(np.arctan2(off[:, 1], off[:, 0]))]
        ids = np.roll(ids, -int(np.argmin(ids)))
        x, y = xy[ids].T
        if abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 1e-12 * radius_mm**2:
            polygons.append((plane, ids))
    return Facets(angles, np.column_stack([xy, top]), len(rim), tuple(polygons))


def facets_over_annulus(planes: Planes, outer_mm: float, inner_mm: float, segments: int) -> Facets:
    """Divide an annulus among planes whose edges all run through the axis."""
    creases = _creases(planes, outer_mm)
    angles, _ = _with_breaks(segments, [angle for angle, _, _ in creases])
    n = len(angles)
    xy = np.concatenate([on_circle(angles, outer_mm), on_circle(angles, inner_mm)])
    middle = angles + np.diff(angles, append=2 * np.pi) / 2
    plane = planes.heights(on_circle(middle, outer_mm)).argmax(axis=0)
    here, after = np.arange(n), np.roll(np.arange(n), -1)
    quads = np.stack([here, after, n + after, n + here], axis=1)
    polygons = tuple((int(k), ids) for k, ids in zip(plane, quads, strict=True))
    return Facets(angles, np.column_stack([xy, planes.over(xy)]), 2 * n, polygons)


def _creases(planes: Planes, radius_mm: float) -> list[tuple[float, int, int]]:
    """Give angle and planes of each point of the circle where two planes are equal and highest."""
    found = []
    level = planes.heights(np.zeros((1, 2)))[:, 0]
    for k, m in itertools.combinations(range(len(level)), 2):
        slope = planes.gradient[k] - planes.gradient[m]
        size = float(np.linalg.norm(slope)) * radius_mm
        fall = level[m] - level[k]
        if size <= abs(fall):  # parallel planes too
            continue
        towards, half = np.arctan2(slope[1], slope[0]), np.arccos(fall / size)
        for angle in (towards - half, towards + half):
            heights = planes.heights(on_circle(np.array([angle]), radius_mm))[:, 0]
            if heights[k] >= heights.max() - 1e-11 * (radius_mm + abs(heights.max())):
                found.append((float(angle % (2 * np.pi)), k, m))
    return found


def _corners(planes: Planes, radius_mm: float) -> Array:
    """Give the points (n, 2) inside the circle where three planes are equal and highest."""
    found: list[Array] = []
    level = planes.heights(np.zeros((1, 2)))[:, 0]
    for k, m, n in itertools.combinations(range(len(level)), 3):
        slopes = planes.gradient[[m, n]] - planes.gradient[k]
        if abs(np.linalg.det(slopes)) < 1e-9:
            continue
        xy = np.linalg.solve(slopes, level[k] - level[[m, n]])
        xy[np.abs(xy) < 1e-14 * radius_mm] = 0.0
        heights = planes.heights(xy[None])[:, 0]
        highest = heights[k] >= heights.max() - 1e-11 * (radius_mm + abs(heights.max()))
        new = all(np.linalg.norm(xy - other) > 1e-9 * radius_mm for other in found)
        if highest and new and np.linalg.norm(xy) < radius_mm * (1 - 1e-9):
            found.append(xy)
    return np.array(found).reshape(-1, 2)


def _with_breaks(segments: int, breaks: list[float]) -> tuple[Array, list[int]]:
    """Add angles to the regular ones, and say at which indices they then are."""
    angles = regular_angles(segments)
    step = 2 * np.pi / segments
    for angle in breaks:
        near = np.abs((angles - angle + np.pi) % (2 * np.pi) - np.pi).min()
        if near > SAME_ANGLE * min(1, step):
            angles = np.sort(np.append(angles, angle))
    at = [int(np.abs((angles - b + np.pi) % (2 * np.pi) - np.pi).argmin()) for b in breaks]
    return angles, at
