"""A calibration target as a thing: printed, a little wrong, on a plate that is not quite flat.

Plate frame, mm: that of the target (`simtip.target`), x and y along the print, z into the plate.
The print is scaled about the first point; then the plate is bent, each point moving along z only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.target import Target

FLAT_MM = 2e-4
"""How far the facets of a bent plate may be off it."""
MOST_FACETS = 500
"""Along a side."""

Faces = NDArray[np.int64]


@dataclass(frozen=True)
class Plate:
    """A printed target on a plate.

    Attributes
    ----------
    target
        What was meant to be printed.
    margin_mm
        Bare plate around the printed pattern.
    thickness_mm
        Of the plate.
    bow_mm
        How far the plate's corners stand off the plane through its middle, away from the viewer:
        above 0 the middle comes towards the viewer. A paraboloid.
    print_scale
        Printed over nominal length, along x and y.
    """

    target: Target
    margin_mm: float = 6.0
    thickness_mm: float = 3.0
    bow_mm: float = 0.0
    print_scale: tuple[float, float] = (1.0, 1.0)

    @property
    def low(self) -> Array:
        """(2,) the plate's corner towards -x, -y, mm."""
        return self.target.low * self.print_scale - self.margin_mm

    @property
    def high(self) -> Array:
        """(2,) the plate's corner towards +x, +y, mm."""
        return self.target.high * self.print_scale + self.margin_mm

    @property
    def middle(self) -> Array:
        """(3,) the middle of the printed side, mm."""
        return np.array([*(self.low + self.high) / 2, 0.0])

    @property
    def points(self) -> Array:
        """(n, 3) where the target's points really are, mm."""
        return self.surface(self.target.points[:, :2] * self.print_scale)

    def outline(self) -> Array:
        """Give points (m, 3), mm, around the edge of the printed side, corners among them."""
        (x0, y0), (x1, y1) = self.low, self.high
        t = np.linspace(0, 1, 9)[:-1]
        sides = [
            (x0 + t * (x1 - x0), y0 + 0 * t),
            (x1 + 0 * t, y0 + t * (y1 - y0)),
            (x1 + t * (x0 - x1), y1 + 0 * t),
            (x0 + 0 * t, y1 + t * (y0 - y1)),
        ]
        return self.surface(np.concatenate([np.stack(side, axis=1) for side in sides]))

    def height(self, st: ArrayLike) -> Array:
        """Give z (n,) of the printed side at (n, 2), mm."""
        off = np.asarray(st, np.float64) - self.middle[:2]
        half = (self.high - self.low) / 2
        risen: Array = self.bow_mm * (off**2).sum(axis=-1) / (half**2).sum()
        return risen

    def surface(self, st: ArrayLike) -> Array:
        """Give the printed side's points (n, 3) over (n, 2), mm."""
        places = np.asarray(st, np.float64)
        return np.concatenate([places, self.height(places)[..., None]], axis=-1)

    def normals(self, st: ArrayLike) -> Array:
        """Give unit normals (n, 3) of the printed side, towards the viewer, over (n, 2) mm."""
        half = (self.high - self.low) / 2
        off = np.asarray(st, np.float64) - self.middle[:2]
        slope = 2 * self.bow_mm * off / (half**2).sum()
        upright = np.concatenate([slope, -np.ones((len(slope), 1))], axis=1)
        normals: Array = upright / np.linalg.norm(upright, axis=1, keepdims=True)
        return normals

    def front(self) -> tuple[Array, Faces]:
        """Give the printed side as a mesh: vertices (n, 3) mm and faces (m, 3), towards -z."""
        size = self.high - self.low
        # A chord of length d under curvature k is off by k d^2 / 8, and there are two directions.
        curvature = 2 * abs(self.bow_mm) / ((size / 2) ** 2).sum()
        counts = np.ceil(size * np.sqrt(curvature / (4 * FLAT_MM))).clip(1, MOST_FACETS)
        xs, ys = (
            np.linspace(low, high, int(count) + 1)
            for low, high, count in zip(self.low, self.high, counts, strict=True)
        )
        grid = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
        columns = len(xs)
        row, column = np.divmod(np.arange((columns - 1) * (len(ys) - 1)), columns - 1)
        a = row * columns + column
        b, c, d = a + 1, a + columns, a + columns + 1
        faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
        return self.surface(grid), faces.astype(np.int64)

    def body(self) -> tuple[Array, Faces]:
        """Give the plate's back and sides as a mesh, likewise."""
        rim = self.outline()
        count = len(rim)
        through = np.array([0, 0, self.thickness_mm])
        back = rim + through
        middle = self.surface(self.middle[None, :2]) + through
        k = np.arange(count)
        after = (k + 1) % count
        sides = np.concatenate([
            np.stack([k, after, k + count], axis=1),
            np.stack([after, after + count, k + count], axis=1),
            np.stack([k + count, after + count, np.full(count, 2 * count)], axis=1),
        ])  # fmt: skip
        return np.concatenate([rim, back, middle]), sides.astype(np.int64)
