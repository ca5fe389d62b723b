"""What a kind of tip has to tell the needle, and the checks that all kinds share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array

Faces = NDArray[np.int64]

SMALLEST_TIP_RADIUS_MM = 1e-4
"""A rounding below 0.1 um is taken for a misprint: it would only make slivers."""

LARGEST_ROUNDING = 0.9
"""Largest tip radius, as a share of the thickness that a ball can fill."""


@dataclass(frozen=True, eq=False)
class Front:
    """The surface that closes the needle towards the tip.

    Attributes
    ----------
    ring
        (n, 2) mm, points on the needle's circle, counter-clockwise seen from the hub.
    rim_z
        (n,) mm, where the cylinder's generator through each point of the ring begins.
    points
        (m, 3) mm, further vertices of the surface.
    faces
        (k, 3), outward; 0 to n - 1 are the rim, n and above are `points`.
    """

    ring: Array
    rim_z: Array
    points: Array
    faces: Faces


class Tip(Protocol):
    """What `Needle` needs to know of a kind of tip, a frozen dataclass; `radius_mm` is the shaft's.

    The solid is the union of all balls of `tip_radius_mm` that fit into the sharp tip, its
    morphological opening; its foremost point has z = 0.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]
    kind: ClassVar[str]

    @property
    def tip_radius_mm(self) -> float:
        """Radius of every edge and corner of the tip, mm; 0 is sharp."""

    def check(self, radius_mm: float) -> None:
        """Raise ValueError, naming the field, where the tip does not suit the shaft."""

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to where the full cylinder begins."""

    def depth_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to the last of the tip's own surface."""

    def apexes_mm(self, radius_mm: float) -> Array:
        """Give the foremost points, (n, 3), needle frame; the first is the tip."""

    def core_mm(self, radius_mm: float, segments: int) -> Array:
        """Give points (n, 3) whose balls of `tip_radius_mm` make up the front."""

    def front(self, radius_mm: float, segments: int, sagitta_mm: float) -> Front:
        """Build the surface over a circle of at least `segments` points.

        No arc of the rounding strays from its chord by more than `sagitta_mm`.
        """


def require_positive(name: str, value: float) -> None:
    """Raise ValueError unless a length is finite and above 0."""
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} has to be a finite length above 0, not {value:g}")


def require_between(name: str, value: float, low: float, high: float) -> None:
    """Raise ValueError unless a figure is at least `low` and below `high`."""
    if not low <= value < high:
        raise ValueError(f"{name} has to be at least {low:g} and below {high:g}, not {value:g}")


def require_rounding(kind: str, tip_radius_mm: float, room_mm: float, room: str) -> None:
    """Raise ValueError unless a ball of the tip radius fits with some room to spare.

    Parameters
    ----------
    kind
        Of tip, for the message.
    tip_radius_mm
        The radius asked for.
    room_mm, room
        Radius of the largest ball that fits, and what it is called.
    """
    largest = LARGEST_ROUNDING * room_mm
    if tip_radius_mm != 0 and not SMALLEST_TIP_RADIUS_MM <= tip_radius_mm <= largest:
        raise ValueError(
            f"the {kind}'s tip_radius_mm has to be 0 or between {SMALLEST_TIP_RADIUS_MM:g} and "
            f"{largest:.4g}, {LARGEST_ROUNDING:g} of {room}, not {tip_radius_mm:g}"
        )


def arc_steps(tip_radius_mm: float, angle: float, sagitta_mm: float) -> int:
    """Give how many chords an arc (rad) of the rounding needs to keep to the sagitta, 8 to 64."""
    if tip_radius_mm == 0:
        return 0
    return min(max(math.ceil(angle * math.sqrt(tip_radius_mm / (8 * sagitta_mm))), 8), 64)


def regular_angles(segments: int) -> Array:
    """Give equal steps around the circle from 0, rad."""
    angles: Array = 2 * np.pi * np.arange(segments) / segments
    return angles


def on_circle(angles: Array, radius_mm: float) -> Array:
    """Give the points (n, 2) of a circle."""
    points: Array = radius_mm * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points
