"""The cone, with a point or a ball at its end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from simtip.geometry import Array
from simtip.needle.tip import (
    Front,
    arc_steps,
    on_circle,
    regular_angles,
    require_positive,
    require_rounding,
)


@dataclass(frozen=True)
class Cone:
    """A cone on the axis; the tip is its foremost point, the origin.

    Attributes
    ----------
    length_mm
        From the sharp apex to the full diameter. A rounded tip is shorter at its front by
        ``r (1 / sin(half angle) - 1)``.
    tip_radius_mm
        Radius of the ball at the end, and of the shoulder where the cone meets the shaft.
    """

    kind: ClassVar[str] = "cone"

    length_mm: float
    tip_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        require_positive("the cone's length_mm", self.length_mm)

    def check(self, radius_mm: float) -> None:
        """Raise ValueError where the ball does not fit into the shaft."""
        require_rounding("cone", self.tip_radius_mm, radius_mm, "the needle's radius")

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to the full diameter."""
        r = self.tip_radius_mm
        return self.length_mm * (1 - r / radius_mm) + r

    depth_mm = extent_mm

    def apexes_mm(self, radius_mm: float) -> Array:  # noqa: ARG002 - the protocol's signature
        """Give the origin."""
        return np.zeros((1, 3))

    def core_mm(self, radius_mm: float, segments: int) -> Array:
        """Give the inner cone's apex and rim: their balls reach as far as all others."""
        r = self.tip_radius_mm
        rim = on_circle(regular_angles(segments), radius_mm - r)
        rim_z = np.full((len(rim), 1), self.extent_mm(radius_mm))
        return np.concatenate([[[0.0, 0.0, r]], np.hstack([rim, rim_z])])

    def front(self, radius_mm: float, segments: int, sagitta_mm: float) -> Front:
        """Build the ball's cap, the cone's side and the shoulder as one surface of revolution."""
        angles = regular_angles(segments)
        rho, z = self._profile(radius_mm, sagitta_mm)
        count = len(rho)  # rings between the rim and the pole
        unit = on_circle(angles, 1.0)
        rings = np.concatenate([unit[None] * rho[:, None, None], _stacked(z, segments)], axis=2)
        pole = segments * (count + 1)
        here = np.arange(segments)
        after = np.roll(here, -1)
        faces = []
        for k in range(count):
            a, b = k * segments, (k + 1) * segments
            faces += [
                np.stack([b + here, b + after, a + after], axis=1),
                np.stack([b + here, a + after, a + here], axis=1),
            ]
        last = count * segments
        faces.append(np.stack([np.full(segments, pole), last + after, last + here], axis=1))
        return Front(
            on_circle(angles, radius_mm),
            np.full(segments, self.extent_mm(radius_mm)),
            np.concatenate([rings.reshape(-1, 3), np.zeros((1, 3))]),
            np.concatenate(faces),
        )

    def _profile(self, radius_mm: float, sagitta_mm: float) -> tuple[Array, Array]:
        """Give radii and z of the rings from just before the rim to just before the pole."""
        r = self.tip_radius_mm
        if r == 0:
            return np.zeros(0), np.zeros(0)
        half_angle = math.atan2(radius_mm, self.length_mm)
        # The normal's angle from -z: 0 at the pole, up to the cone's, up to pi/2 at the rim.
        side = math.pi / 2 - half_angle
        shoulder = np.linspace(np.pi / 2, side, 1 + arc_steps(r, half_angle, sagitta_mm))[1:]
        cap = np.linspace(side, 0, 1 + arc_steps(r, side, sagitta_mm))[:-1]
        rho = [radius_mm - r + r * np.sin(shoulder), r * np.sin(cap)]
        z = [self.extent_mm(radius_mm) - r * np.cos(shoulder), r - r * np.cos(cap)]
        return np.concatenate(rho), np.concatenate(z)


def _stacked(z: Array, segments: int) -> Array:
    return np.broadcast_to(z[:, None, None], (len(z), segments, 1))
