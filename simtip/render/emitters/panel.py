"""Light from a flat rectangle, sampled evenly over its area."""

from __future__ import annotations

from typing import Any

import numpy as np

from simtip.geometry import Array, unit
from simtip.render.emitters.sample import LampSample
from simtip.render.engine import dr, mi

Vec = Any  # a Dr.Jit vector of the active variant: these types exist only once it is set


class Panel:
    """A rectangle that shines to the side of its normal."""

    def __init__(self, centre: Array, along: Array, normal: Array, size_mm: Array) -> None:
        z = unit(normal)
        x = unit(along - (along @ z) * z)
        self._matrix = np.eye(4)
        self._matrix[:3, 0] = x * size_mm[0] / 2
        self._matrix[:3, 1] = np.cross(z, x) * size_mm[1] / 2
        self._matrix[:3, 2] = z
        self._matrix[:3, 3] = centre
        self._x, self._y, self._normal = (
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in self._matrix[:3, k]])
            for k in range(3)
        )
        self._centre = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in centre])
        self._area = dr.opaque(mi.Float, float(np.prod(size_mm)))

    def shape(self) -> dict[str, Any]:
        """Describe it to Mitsuba."""
        return {"type": "rectangle", "to_world": mi.ScalarTransform4f(self._matrix.tolist())}

    def sample(self, x: Vec, xi: Vec) -> LampSample:
        """Sample a point with two uniform numbers ``xi``."""
        point = self._centre + (2 * xi.x - 1) * self._x + (2 * xi.y - 1) * self._y
        to_point = point - x
        d2 = dr.squared_norm(to_point)
        direction = to_point * dr.rsqrt(d2)
        cosine = -dr.dot(direction, self._normal)
        weight = dr.select(cosine > 0, self._area * cosine / d2, 0)
        return LampSample(point, direction, weight, dr.select(cosine > 0, dr.rcp(weight), 0))

    def pdf(self, x: Vec, point: Vec, normal: Vec) -> Vec:
        """Density per solid angle at x with which `sample` finds a point of the rectangle."""
        to_point = point - x
        d2 = dr.squared_norm(to_point)
        cosine = -dr.dot(to_point, normal) * dr.rsqrt(d2)
        return dr.select(cosine > 0, d2 / (self._area * cosine), 0)
