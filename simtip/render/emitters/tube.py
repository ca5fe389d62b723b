"""Light from a straight tube, sampled where a point sees it.

The tube is a cylinder of equal radiance all over. Along its axis it is sampled equi-angularly
(Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media"),
which cancels the 1/d^2; across it, evenly over the width that the point sees, which cancels the
emitter's cosine. (Over the half that faces the point in proportion to the normal's cosine, as is
simpler, one sample in ten thousand is worth nothing and makes a dark spot.)
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

    def _seen_from(self, x: Vec) -> tuple[Vec, Vec, Vec, Vec, Vec]:
        """Give foot of x on the axis, distance, unit normal and the angles of the ends."""
        to_x = x - self.centre
        foot = dr.dot(to_x, self.axis)
        across = dr.fma(-foot, self.axis, to_x)
        distance = dr.norm(across)
        theta_min = dr.atan((-self.half - foot) / distance)
        theta_max = dr.atan((self.half - foot) / distance)
        return foot, distance, across / distance, theta_min, theta_max

    def sample(self, x: Vec, xi: Vec) -> LampSample:
        """Sample a point with two uniform numbers ``xi``."""
        foot, distance, outwards, theta_min, theta_max = self._seen_from(x)
        along = foot + distance * dr.tan(dr.lerp(theta_min, theta_max, xi.x))
        # In the plane across the axis: q is the ray's offset from the axis over the radius, alpha
        # its angle at x, and q the sine of the angle at which it meets the tube.
        q = 2 * xi.y - 1
        sin_alpha = q * self.radius / distance
        cos_alpha, cos_met = dr.safe_sqrt(1 - sin_alpha * sin_alpha), dr.safe_sqrt(1 - q * q)
        cos_phi = dr.fma(cos_met, cos_alpha, q * sin_alpha)
        sin_phi = dr.fma(q, cos_alpha, -cos_met * sin_alpha)
        normal = dr.fma(cos_phi, outwards, sin_phi * dr.cross(self.axis, outwards))
        point = self.centre + along * self.axis + self.radius * normal
        to_point = point - x
        direction = to_point * dr.rsqrt(dr.squared_norm(to_point))
        pdf = self._pdf(along - foot, cos_phi, distance, theta_max - theta_min)
        seen = distance > self.radius
        return LampSample(
            point, direction, dr.select(seen, dr.rcp(pdf), 0), dr.select(seen, pdf, 0)
        )

    def pdf(self, x: Vec, point: Vec, normal: Vec) -> Vec:
        """Density per solid angle at x with which `sample` finds a point of the tube."""
        foot, distance, outwards, theta_min, theta_max = self._seen_from(x)
        along = dr.dot(point - self.centre, self.axis)
        cos_phi = dr.dot(normal, outwards)
        pdf = self._pdf(along - foot, cos_phi, distance, theta_max - theta_min)
        return dr.select(distance * cos_phi > self.radius, pdf, 0)

    def _pdf(self, along: Vec, cos_phi: Vec, distance: Vec, angle: Vec) -> Vec:
        """Density per solid angle; the lamp's cosine has dropped out, so that it is never 0."""
        across2 = dr.square(distance) + self.radius * (self.radius - 2 * distance * cos_phi)
        cos_alpha = (distance - self.radius * cos_phi) * dr.rsqrt(across2)
        d2 = across2 + dr.square(along)
        per_length = distance / (angle * (dr.square(distance) + dr.square(along)))
        return per_length * distance * cos_alpha * d2 * dr.sqrt(d2) / (2 * self.radius * across2)
