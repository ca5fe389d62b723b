"""Tips that are sharp on one side: single bevel, lancet, back-bevel.

The names of the grinds, and which side the secondary ones lie on, are those of the trade
(ISPG's glossary of needle grinding; ISO 7864, figure of needle points; Han, Che, Pallav and
Ehmann 2012, "Models of the cutting edge geometry of medical needles").
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from simtip.geometry import Array
from simtip.needle.ground import GroundTip
from simtip.needle.planes import Planes
from simtip.needle.tip import require_between

SMALLEST_ANGLE_DEG = 1.0


@dataclass(frozen=True)
class Bevel(GroundTip):
    """A single plane cut: ``z >= (R - x) / tan(angle)``, so a sharp one's tip is (R, 0, 0).

    Rounded, the tip is the ball's foremost point, (R - r, 0, 0).

    Attributes
    ----------
    angle_deg
        Between the cut plane and the axis, at least 1: 90 would be a blunt end.
    tip_radius_mm
        Radius of the edge all around.
    """

    kind: ClassVar[str] = "bevel"

    angle_deg: float
    tip_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        require_between("the bevel's angle_deg", self.angle_deg, SMALLEST_ANGLE_DEG, 90)

    def planes(self, radius_mm: float) -> Planes:
        """Give the cut."""
        slope = 1 / math.tan(math.radians(self.angle_deg))
        return Planes(np.array([[-slope, 0.0]]), np.array([[radius_mm, 0.0, 0.0]]))

    def foremost(self, radius_mm: float) -> Array:
        """Give the point at +x."""
        return np.array([[radius_mm - self.tip_radius_mm, 0.0]])


@dataclass(frozen=True)
class Lancet(GroundTip):
    """A bevel whose front part is ground away on either side: three planes, as on most injections.

    The side bevels are made on the bevel's own side, the needle turned by +-`side_turn_deg` about
    its axis. They meet in a ridge that runs from the tip, (R, 0, 0) when sharp, to the bevel.

    Attributes
    ----------
    angle_deg
        Between the first bevel and the axis.
    side_angle_deg
        Between each side bevel and the axis.
    side_turn_deg
        Turn about the axis for each of them, either way.
    side_share
        Length of the side bevels along the rim, as a share of the first bevel's ``2 R / tan``.
    tip_radius_mm
        Radius of every edge.
    """

    kind: ClassVar[str] = "lancet"

    angle_deg: float = 12.0
    side_angle_deg: float = 18.0
    side_turn_deg: float = 35.0
    side_share: float = 0.5
    tip_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        require_between("the lancet's angle_deg", self.angle_deg, SMALLEST_ANGLE_DEG, 90)
        require_between("the lancet's side_angle_deg", self.side_angle_deg, SMALLEST_ANGLE_DEG, 90)
        require_between("the lancet's side_turn_deg", self.side_turn_deg, 1, 90)
        require_between("the lancet's side_share", self.side_share, 0.05, 0.95)
        if self._ground_off() <= 0:
            raise ValueError(
                "the lancet's side bevels do not meet before the first bevel: side_angle_deg has to"
                f" be above {self._smallest_side_angle_deg():.4g} for this angle_deg, side_turn_deg"
                f" and side_share, not {self.side_angle_deg:g}"
            )

    def _ground_off(self) -> float:
        """Give how much of the first bevel's length the side bevels take, in needle radii."""
        slope, side_slope = (
            1 / math.tan(math.radians(a)) for a in (self.angle_deg, self.side_angle_deg)
        )
        return 2 * self.side_share * slope - self._side_run() * side_slope

    def _side_run(self) -> float:
        """Give the way across the side bevel from the tip to its end on the rim, in needle radii.

        It ends on the rim where the first bevel is `side_share` of its length behind its front:
        at (1 - 2 s, 2 sqrt(s (1 - s))) radii.
        """
        turn, s = math.radians(self.side_turn_deg), self.side_share
        return math.cos(turn) * 2 * s + math.sin(turn) * 2 * math.sqrt(s * (1 - s))

    def _smallest_side_angle_deg(self) -> float:
        slope = 1 / math.tan(math.radians(self.angle_deg))
        return math.degrees(math.atan2(self._side_run(), 2 * self.side_share * slope))

    def planes(self, radius_mm: float) -> Planes:
        """Give the first bevel and the two side bevels."""
        turn = math.radians(self.side_turn_deg)
        point = np.array(
            [[radius_mm, 0, -self._ground_off() * radius_mm]] + [[radius_mm, 0, 0]] * 2
        )
        angles = np.radians([self.angle_deg, self.side_angle_deg, self.side_angle_deg])
        return Planes.through(point, angles, np.array([np.pi, np.pi - turn, np.pi + turn]))

    def foremost(self, radius_mm: float) -> Array:
        """Give the point at +x."""
        return np.array([[radius_mm - self.tip_radius_mm, 0.0]])


@dataclass(frozen=True)
class BackBevel(GroundTip):
    """A bevel with two secondary grinds on the far side of it, so that the tip moves off the wall.

    Attributes
    ----------
    angle_deg
        Between the first bevel and the axis.
    back_angle_deg
        Between each back bevel and the axis.
    back_turn_deg
        Turn of each from the side opposite the first bevel, either way.
    inset_share
        How far the sharp tip lies inside the wall, as a share of the needle's radius: the sharp
        tip is ``((1 - inset_share) R, 0, 0)``.
    tip_radius_mm
        Radius of every edge.
    """

    kind: ClassVar[str] = "back_bevel"

    angle_deg: float = 12.0
    back_angle_deg: float = 18.0
    back_turn_deg: float = 35.0
    inset_share: float = 0.25
    tip_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        require_between("the back_bevel's angle_deg", self.angle_deg, SMALLEST_ANGLE_DEG, 90)
        require_between(
            "the back_bevel's back_angle_deg", self.back_angle_deg, SMALLEST_ANGLE_DEG, 90
        )
        require_between("the back_bevel's back_turn_deg", self.back_turn_deg, 1, 90)
        require_between("the back_bevel's inset_share", self.inset_share, 0.01, 1)

    def planes(self, radius_mm: float) -> Planes:
        """Give the first bevel and the two back bevels, all through the sharp tip."""
        turn = math.radians(self.back_turn_deg)
        angles = np.radians([self.angle_deg, self.back_angle_deg, self.back_angle_deg])
        tip = (radius_mm * (1 - self.inset_share), 0.0, 0.0)
        return Planes.through(tip, angles, np.array([np.pi, turn, -turn]))

    def foremost(self, radius_mm: float) -> Array:
        """Give the point where the bevel meets the ridge of the back bevels.

        Planes at different angles move differently when the edges are rounded, and the point where
        they meet moves with them, at most to the rim: there one of the grinds is rounded away.
        """
        r = self.tip_radius_mm
        planes = self.planes(radius_mm).moved(r)
        (front, ridge), (rise, fall) = planes.point[:2, 2], planes.gradient[:2, 0]
        x = radius_mm * (1 - self.inset_share) + (ridge - front) / (rise - fall)
        return np.array([[min(max(x, r - radius_mm), radius_mm - r), 0.0]])
