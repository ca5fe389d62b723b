"""The needle's geometry, and the one definition of its tip.

Needle frame, mm: z runs along the axis from the tip to the hub, the axis is x = y = 0, the
foremost point of the solid has z = 0 and the hub's end face z = length. The **tip** is the apex:
one 3-D point of the solid, `Needle.apex`. What a camera sees foremost, the extreme point of the
silhouette, is another thing for bevelled and rounded tips: `simtip.silhouette` gives that one.

A new kind of tip is a frozen dataclass with the three methods of `Tip`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array, Pose, unit

if TYPE_CHECKING:
    import trimesh

Faces = NDArray[np.int64]

SEGMENTS = 1024
"""Sides of the polygon that stands for the circle: 3.9 nm off a radius of 0.835 mm at most."""


@dataclass(frozen=True, eq=False)
class Front:
    """The surface that closes the needle towards the tip.

    Attributes
    ----------
    rim_z
        (n,) mm, where the cylinder's generator through each point of the ring begins.
    points
        (m, 3) mm, further vertices of the surface.
    faces
        (k, 3), outward; 0 to n - 1 are the rim, n and above are `points`.
    """

    rim_z: Array
    points: Array
    faces: Faces


class Tip(Protocol):
    """What `Needle` needs to know of a kind of tip, a dataclass; radii in mm."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to where the full cylinder begins."""

    def apex_mm(self, radius_mm: float) -> Array:
        """Give the tip, (3,), needle frame."""

    def front(self, ring: Array, radius_mm: float) -> Front:
        """Build the surface over a ring (n, 2) of points on the circle, counter-clockwise."""


def _fan(rim_z: Array, centre: ArrayLike) -> Front:
    """Join a rim to one point."""
    n = len(rim_z)
    here = np.arange(n)
    faces = np.stack([np.full(n, n), np.roll(here, -1), here], axis=1)
    return Front(rim_z, np.array([centre], dtype=np.float64), faces)


@dataclass(frozen=True)
class Cone:
    """A cone on the axis; the tip is its apex, the origin.

    Attributes
    ----------
    length_mm
        From the apex to the full diameter.
    """

    length_mm: float

    def __post_init__(self) -> None:
        _require_positive("the cone's length_mm", self.length_mm)

    def extent_mm(self, radius_mm: float) -> float:  # noqa: ARG002 - the protocol's signature
        """Give the cone's length."""
        return self.length_mm

    def apex_mm(self, radius_mm: float) -> Array:  # noqa: ARG002 - the protocol's signature
        """Give the origin."""
        return np.zeros(3)

    def front(self, ring: Array, radius_mm: float) -> Front:  # noqa: ARG002 - as above
        """Build the cone's side."""
        return _fan(np.full(len(ring), self.length_mm), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Bevel:
    """A single plane cut: the solid is ``z >= (R - x) / tan(angle)``, so the tip is (R, 0, 0).

    Attributes
    ----------
    angle_deg
        Between the cut plane and the axis, at least 1: 90 would be a blunt end.
    """

    angle_deg: float

    def __post_init__(self) -> None:
        if not 1 <= self.angle_deg < 90:
            raise ValueError(
                f"the bevel's angle_deg has to be at least 1 and below 90, not {self.angle_deg:g}"
            )

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length of the cut, seen from the side."""
        return 2 * radius_mm / math.tan(math.radians(self.angle_deg))

    def apex_mm(self, radius_mm: float) -> Array:
        """Give the foremost point of the cut."""
        return np.array([radius_mm, 0.0, 0.0])

    def front(self, ring: Array, radius_mm: float) -> Front:
        """Build the flat, elliptic cut."""
        slope = 1 / math.tan(math.radians(self.angle_deg))
        return _fan((radius_mm - ring[:, 0]) * slope, (0.0, 0.0, radius_mm * slope))


@dataclass(frozen=True)
class Needle:
    """A straight, solid, round needle, closed at the hub by a flat face.

    Attributes
    ----------
    diameter_mm, length_mm
        Outer diameter; length from the foremost point to the hub's end face.
    tip
        The tip's shape, shorter than the needle.

    Raises
    ------
    ValueError
        A length is not a finite number above zero, or the tip does not fit within the length.
    """

    diameter_mm: float
    length_mm: float
    tip: Tip

    def __post_init__(self) -> None:
        _require_positive("diameter_mm", self.diameter_mm)
        _require_positive("length_mm", self.length_mm)
        extent = self.tip.extent_mm(self.radius_mm)
        if not extent < self.length_mm:
            raise ValueError(
                f"the tip is {extent:g} mm long and does not fit in the needle's "
                f"{self.length_mm:g} mm"
            )

    @property
    def radius_mm(self) -> float:
        """Half the diameter."""
        return self.diameter_mm / 2

    @property
    def apex(self) -> Array:
        """The tip, (3,) mm, needle frame: the truth that everything is scored against."""
        return self.tip.apex_mm(self.radius_mm)

    def surface(self, segments: int = SEGMENTS) -> tuple[Array, Faces]:
        """Give the closed surface as vertices (n, 3), mm, needle frame, and outward faces (m, 3).

        Ring vertices lie on the circle of the stated diameter, so the solid is inscribed: its
        silhouette is narrow by at most ``R (1 - cos(pi / segments))`` a side. The apex, and the
        points at x = +-R and y = +-R, are among the vertices.

        Raises
        ------
        ValueError
            `segments` is below 8 or no multiple of 4.
        """
        if segments < 8 or segments % 4:
            raise ValueError(f"segments has to be a multiple of 4, at least 8, not {segments}")
        angle = 2 * np.pi * np.arange(segments) / segments
        ring = self.radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        front = self.tip.front(ring, self.radius_mm)
        here, after = np.arange(segments), np.roll(np.arange(segments), -1)
        hub = segments + len(front.points)  # rim, points of the front, hub's ring, hub's centre
        centre = np.full(segments, hub + segments)
        vertices = np.concatenate(
            [
                np.column_stack([ring, front.rim_z]),
                front.points,
                np.column_stack([ring, np.full(segments, self.length_mm)]),
                [[0.0, 0.0, self.length_mm]],
            ]
        )
        faces = np.concatenate(
            [
                front.faces,
                np.stack([here, after, hub + after], axis=1),
                np.stack([here, hub + after, hub + here], axis=1),
                np.stack([centre, hub + here, hub + after], axis=1),
            ]
        )
        return vertices, faces

    def mesh(self, segments: int = SEGMENTS) -> trimesh.Trimesh:
        """Build the watertight `trimesh.Trimesh` of `surface`: mm, needle frame, outward faces."""
        import trimesh

        vertices, faces = self.surface(segments)
        return trimesh.Trimesh(vertices, faces, process=False)

    def pose(self, apex_mm: ArrayLike, axis: ArrayLike, roll_deg: float = 0.0) -> Pose:
        """Give T_wn, which puts the apex at a point and the needle's z along an axis.

        At roll 0 the needle's x axis is world +x less its part along the axis (world +z takes the
        place of +x within 0.6 degrees of it), so for the default axis (0, -1, 0) the needle's
        x, y, z are world +x, +z, -y, and they turn smoothly with the axis around there.

        Parameters
        ----------
        apex_mm
            (3,) mm, world.
        axis
            (3,) from the tip to the hub, world, any length.
        roll_deg
            Right-handed turn about the axis, degrees.

        Raises
        ------
        ValueError
            The axis has no length.
        """
        z = unit(axis)
        reference = np.array([1.0, 0, 0]) if abs(z[0]) < math.cos(0.01) else np.array([0, 0, 1.0])
        x0 = unit(reference - (reference @ z) * z)
        y0 = np.cross(z, x0)
        roll = math.radians(roll_deg)
        x = math.cos(roll) * x0 + math.sin(roll) * y0
        R = np.stack([x, np.cross(z, x), z], axis=1)
        return Pose(R, np.asarray(apex_mm, dtype=np.float64) - R @ self.apex)


def _require_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} has to be a finite length above 0, not {value:g}")
