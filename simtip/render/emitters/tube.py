"""Light from a straight tube, sampled where a point sees it.

The tube is a cylinder of equal radiance all over. Along its axis it is sampled equi-angularly
(Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media"),
which cancels the 1/d^2; around it, only over the half that the point sees, in proportion to the
cosine, which cancels the emitter's cosine to first order in radius/distance.
"""

from __future__ import annotations

from typing import Any

from simtip.geometry import Array, unit
from simtip.render.emitters.sample import LampSample
from simtip.render.engine import dr, mi

Vec = Any  # a Dr.Jit vector of the active variant: these types exist only once it is set


class Tube:
    """A lit cylinder in the renderer's own numbers, kept opaque so that no kernel embeds them."""

    def __init__(self, centre: Array, along: Array, length_mm: float, diameter_mm: float) -> None:
        axis = unit(along)
        self._ends = centre - axis * length_mm / 2, centre + axis * length_mm / 2
        self._radius_mm = diameter_mm / 2
        self.centre = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in centre])
        self.axis = mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in axis])
        self.half = dr.opaque(mi.Float, length_mm / 2)
        self.radius = dr.opaque(mi.Float, diameter_mm / 2)

    def shape(self) -> dict[str, Any]:
        """Describe it to Mitsuba."""
        start, end = self._ends
        return {
            "type": "cylinder",
            "p0": start.tolist(),
            "p1": end.tolist(),
            "radius": self._radius_mm,
        }

    def _seen_from(self, x: Vec) -> tuple[Vec, Vec, Vec, Vec, Vec, Vec]:
        """Give foot of x on the axis, distance, unit normal, angles of the ends, sin(phi_max)."""
        to_x = x - self.centre
        foot = dr.dot(to_x, self.axis)
        across = dr.fma(-foot, self.axis, to_x)
        distance = dr.norm(across)
        theta_min = dr.atan((-self.half - foot) / distance)
        theta_max = dr.atan((self.half - foot) / distance)
        sin_max = dr.safe_sqrt(1 - dr.square(self.radius / distance))
        return foot, distance, across / distance, theta_min, theta_max, sin_max

    def sample(self, x: Vec, xi: Vec) -> LampSample:
        """Sample a point with two uniform numbers ``xi``."""
        foot, distance, outwards, theta_min, theta_max, sin_max = self._seen_from(x)
        theta = dr.lerp(theta_min, theta_max, xi.x)
        along = foot + distance * dr.tan(theta)
        sin_phi = (2 * xi.y - 1) * sin_max
        cos_phi = dr.safe_sqrt(1 - dr.square(sin_phi))
        normal = dr.fma(cos_phi, outwards, sin_phi * dr.cross(self.axis, outwards))
        point = self.centre + along * self.axis + self.radius * normal
        to_point = point - x
        d2 = dr.squared_norm(to_point)
        direction = to_point * dr.rsqrt(d2)
        cos_lamp = -dr.dot(direction, normal)
        pdf_area = self._pdf_area(along, cos_phi, foot, distance, theta_max - theta_min, sin_max)
        seen = (cos_lamp > 0) & (pdf_area > 0)
        weight = dr.select(seen, cos_lamp / (d2 * pdf_area), 0)
        return LampSample(point, direction, weight, dr.select(seen, dr.rcp(weight), 0))

    def pdf(self, x: Vec, point: Vec, normal: Vec) -> Vec:
        """Density per solid angle at x with which `sample` finds a point of the tube."""
        foot, distance, outwards, theta_min, theta_max, sin_max = self._seen_from(x)
        along = dr.dot(point - self.centre, self.axis)
        cos_phi = dr.dot(normal, outwards)
        to_point = point - x
        d2 = dr.squared_norm(to_point)
        cos_lamp = -dr.dot(to_point, normal) * dr.rsqrt(d2)
        pdf_area = self._pdf_area(along, cos_phi, foot, distance, theta_max - theta_min, sin_max)
        return dr.select((cos_lamp > 0) & (cos_phi > 0), pdf_area * d2 / cos_lamp, 0)

    def _pdf_area(
        self, along: Vec, cos_phi: Vec, foot: Vec, distance: Vec, angle: Vec, sin_max: Vec
    ) -> Vec:
        per_length = distance / (angle * (dr.square(distance) + dr.square(along - foot)))
        return per_length * cos_phi / (2 * sin_max * self.radius)
