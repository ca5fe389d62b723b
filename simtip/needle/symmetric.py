"""Tips that are the same all around the axis in equal steps: blunt, trocar, diamond, Franseen."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from typing_extensions import override

from simtip.geometry import Array
from simtip.needle.ground import GroundTip
from simtip.needle.planes import Planes
from simtip.needle.tip import require_between, require_rounding

SMALLEST_ANGLE_DEG = 3.0
BORE_DEPTH = 4.0
"""How deep the bore is beyond the ground part, in needle diameters: its floor is out of sight."""


@dataclass(frozen=True)
class Blunt(GroundTip):
    """A flat end square to the axis; the tip is the middle of the flat, the origin.

    Attributes
    ----------
    tip_radius_mm
        Radius of the edge around the flat.
    """

    kind: ClassVar[str] = "blunt"

    tip_radius_mm: float = 0.0

    @override
    def planes(self, radius_mm: float) -> Planes:
        """Give the flat."""
        return Planes(np.zeros((1, 2)), np.zeros((1, 3)))

    @override
    def foremost(self, radius_mm: float) -> Array:
        """Give the middle of the flat."""
        return np.zeros((1, 2))


@dataclass(frozen=True)
class Pyramid(GroundTip):
    """Equal planes that meet on the axis; the tip is that point, the origin, sharp or rounded.

    One edge lies at azimuth 0, over needle +x.
    """

    count: ClassVar[int]

    @property
    @abstractmethod
    def angle_deg(self) -> float:
        """Between each plane and the axis, degrees."""

    def __post_init__(self) -> None:
        require_between(f"the {self.kind}'s angle_deg", self.angle_deg, SMALLEST_ANGLE_DEG, 90)

    @override
    def planes(self, radius_mm: float) -> Planes:
        """Give the planes, their middles between the edges."""
        azimuth = (2 * np.arange(self.count) + 1) * np.pi / self.count
        return Planes.through((0.0, 0.0, 0.0), np.array([math.radians(self.angle_deg)]), azimuth)

    @override
    def foremost(self, radius_mm: float) -> Array:
        """Give the axis."""
        return np.zeros((1, 2))


@dataclass(frozen=True)
class Trocar(Pyramid):
    """Three equal planes that meet on the axis.

    Attributes
    ----------
    angle_deg
        Between each plane and the axis.
    tip_radius_mm
        Radius of every edge, and of the ball at the tip.
    """

    kind: ClassVar[str] = "trocar"
    count: ClassVar[int] = 3

    angle_deg: float = 20.0
    tip_radius_mm: float = 0.0


@dataclass(frozen=True)
class Diamond(Pyramid):
    """Four equal planes that meet on the axis; the figures are those of `Trocar`."""

    kind: ClassVar[str] = "diamond"
    count: ClassVar[int] = 4

    angle_deg: float = 20.0
    tip_radius_mm: float = 0.0


@dataclass(frozen=True)
class Franseen(Pyramid):
    """A crown: a tube ground by three equal planes, which leaves three points at its bore.

    The planes are a trocar's; the bore takes the middle away, so that the foremost points are
    where the three edges begin at the bore's wall: azimuths 0, 120 and 240 degrees. The tip is
    the one at +x; the others are as far forward. The bore ends blind, well out of sight.

    Attributes
    ----------
    angle_deg
        Between each plane and the axis.
    bore_share
        Diameter of the bore, as a share of the needle's.
    tip_radius_mm
        Radius of every edge, at most 0.9 of half the wall.
    """

    kind: ClassVar[str] = "franseen"
    count: ClassVar[int] = 3

    angle_deg: float = 20.0
    bore_share: float = 0.72
    tip_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_between("the franseen's bore_share", self.bore_share, 0.05, 0.98)

    def bore_mm(self, radius_mm: float) -> float:
        """Give the bore's radius."""
        return radius_mm * self.bore_share

    def bore_depth_mm(self, radius_mm: float) -> float:
        """Give four diameters."""
        return BORE_DEPTH * 2 * radius_mm

    def check(self, radius_mm: float) -> None:
        """Raise ValueError where the rounding does not fit into the wall."""
        half_wall = (radius_mm - self.bore_mm(radius_mm)) / 2
        require_rounding(self.kind, self.tip_radius_mm, half_wall, "half the wall's thickness")

    def foremost(self, radius_mm: float) -> Array:
        """Give the three points, the one at +x first."""
        at = self.bore_mm(radius_mm) + self.tip_radius_mm
        azimuth = 2 * np.pi * np.arange(3) / 3
        return at * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
