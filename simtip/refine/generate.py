"""Needles named by a few figures: ``cone:DIAMETER:LENGTH``, ``bevel:DIAMETER:ANGLE``."""

from __future__ import annotations

import math

import numpy as np

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.refine.solid import Faces, Solid

FORMS = "cone:DIAMETER_MM:LENGTH_MM or bevel:DIAMETER_MM:ANGLE_DEG"

SEGMENTS = 1024
"""Of the circle."""

SHAFT_DIAMETERS = 40.0
"""How long the shaft is made."""

LARGEST_MM = 1e4


def named(text: str) -> Solid:
    """Build the needle that a text names.

    Parameters
    ----------
    text
        ``cone:D:L``, a sharp cone of length L mm on a shaft of diameter D mm; or ``bevel:D:A``, a
        plane cut at A degrees to the axis, whose tip lies at x = D / 2.

    Raises
    ------
    InputError
        It is of neither form, or a figure is out of range.
    """
    kind, *figures = (part.strip() for part in text.split(":"))
    try:
        diameter, second = (float(figure) for figure in figures)
    except ValueError:
        raise InputError(f"{text[:80]!r} names no needle", remedy=f"write {FORMS}") from None
    if not 0 < diameter <= LARGEST_MM:
        raise InputError(f"the diameter is {diameter:g} mm", remedy="give mm above 0, at most 1e4")
    if kind == "cone":
        if not 0.05 * diameter <= second <= 100 * diameter:
            raise InputError(
                f"the cone is {second:g} mm long", remedy="give 0.05 to 100 times the diameter"
            )
        return cone(diameter, second)
    if kind == "bevel":
        if not 1 <= second < 90:
            raise InputError(
                f"the bevel's angle is {second:g} degrees", remedy="give at least 1 and below 90"
            )
        return bevel(diameter, second)
    raise InputError(f"{text[:80]!r} names no needle", remedy=f"write {FORMS}")


def cone(diameter_mm: float, length_mm: float) -> Solid:
    """Give a sharp cone on a shaft."""
    ring = _circle(diameter_mm / 2)
    apex = np.zeros(3)
    rim = np.column_stack([ring, np.full(len(ring), length_mm)])
    return Solid.from_mesh(*_closed(rim, apex, diameter_mm), apex)


def bevel(diameter_mm: float, angle_deg: float) -> Solid:
    """Give a shaft cut by one plane, the tip at x = D / 2."""
    radius, slope = diameter_mm / 2, 1 / math.tan(math.radians(angle_deg))
    ring = _circle(radius)
    rim = np.column_stack([ring, (radius - ring[:, 0]) * slope])
    middle = np.array([0.0, 0.0, radius * slope])
    return Solid.from_mesh(*_closed(rim, middle, diameter_mm), np.array([radius, 0.0, 0.0]))


def _circle(radius_mm: float) -> Array:
    angles = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    return np.asarray(radius_mm * np.column_stack([np.cos(angles), np.sin(angles)]))


def _closed(rim: Array, front: Array, diameter_mm: float) -> tuple[Array, Faces]:
    """Give vertices and faces of a rim (n, 3), closed by a fan from `front` and by a shaft."""
    n = len(rim)
    end = float(rim[:, 2].max()) + SHAFT_DIAMETERS * diameter_mm
    hub = np.column_stack([rim[:, :2], np.full(n, end)])
    here, after = np.arange(n), np.roll(np.arange(n), -1)
    first, last = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    faces = [
        (first, after, here),
        (here, after, n + after),
        (here, n + after, n + here),
        (last, n + here, n + after),
    ]
    vertices = np.concatenate([rim, hub, front[None], [[0.0, 0.0, end]]])
    return vertices, np.concatenate([np.stack(one, axis=1) for one in faces])
