"""The background's plane and its own coordinates (s, t), mm from its centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array, unit
from simtip.spec import BackgroundSpec


@dataclass(frozen=True, eq=False)
class Board:
    """A rectangle: world point = centre + s * x + t * y, |s| <= half[0], |t| <= half[1]."""

    centre: Array
    x: Array
    y: Array
    normal: Array
    half: Array

    @classmethod
    def of(cls, background: BackgroundSpec) -> Board:
        """Place it: x is as near to the world's x as the normal allows."""
        normal = unit(np.array(background.normal))
        upright = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
        x = unit(np.cross(upright, normal))
        return cls(
            centre=np.array(background.centre_mm),
            x=x,
            y=np.cross(normal, x),
            normal=normal,
            half=np.array(background.size_mm) / 2,
        )

    def matrix(self) -> Array:
        """Give the (4, 4) transform of the unit square [-1, 1]^2 to the board."""
        m = np.eye(4)
        m[:3, :3] = np.stack([self.x * self.half[0], self.y * self.half[1], self.normal], axis=1)
        m[:3, 3] = self.centre
        return m

    def meet(self, origin: Array, directions: Array) -> Array:
        """Where rays (..., 3) from `origin` meet the plane: (..., 2) mm; NaN where they do not."""
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = ((self.centre - origin) @ self.normal) / (directions @ self.normal)
            distance = np.where(distance > 0, distance, np.nan)
            points = origin + distance[..., None] * directions - self.centre
        return np.stack([points @ self.x, points @ self.y], axis=-1)

    def points(self, st: Array) -> Array:
        """World points (..., 3) of board coordinates (..., 2)."""
        found: Array = self.centre + st[..., :1] * self.x + st[..., 1:] * self.y
        return found

    def normals(self, st: Array) -> Array:
        """World normals (..., 3) at board coordinates (..., 2)."""
        return np.broadcast_to(self.normal, (*st.shape[:-1], 3))
