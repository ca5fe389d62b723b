"""Outlines of needle tips in the image, as convex polygons.

Coordinates: z along the axis from the foremost point towards the hub, x across it; units are those
of the half width h that is given. Each family has a few shape parameters; lengths among them are in
half widths, so that they do not change with the distance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array

HIDDEN_RAD = 0.5

LONGER = 1.15

ARC_POINTS = 64
"""Of a rounding or a bevel's arc."""

_ROUND = np.linspace(0, 2 * np.pi, 2 * ARC_POINTS, endpoint=False)
_STEPS = np.linspace(-1, 1, 2 * ARC_POINTS - 1)
_LEFT, _RIGHT = np.minimum(_STEPS, 0), np.maximum(_STEPS, 0)
"""Angles about a rim, and along it from its left end over the apex to its right end."""


@dataclass(frozen=True)
class Family:
    """One kind of tip.

    Attributes
    ----------
    name
        As in `needle.tip.kind` where there is one.
    polygon
        From half width h (px), shape (n,), the length z at which to cut off the shaft (px), and the
        tilt, to vertices (m, 2) x, z from the shaft's left end round the tip to its right end. The
        tilt is the sine of the axis, towards the hub, along the line of sight: with it a circle
        about the axis is seen as an ellipse.
    apex
        From h, shape and tilt to x and z of the apex, px.
    depth
        From h and shape to z at which the tip ends and the shaft is whole, px.
    facet
        From half width h (px), shape and tilt to the outline (m, 2) of what is lit in its own way,
        not as the shaft is; None: all up to the depth is. No corners: nothing is.
    starts
        From what the edges suggest (see `simtip.detect.subpixel.start`) to shapes to begin with.
    low, high
        (n,) bounds of the shape.
    """

    name: str
    polygon: Callable[[float, Array, float, float], Array]
    apex: Callable[[float, Array, float], tuple[float, float]]
    depth: Callable[[float, Array], float]
    facet: Callable[[float, Array, float], Array] | None
    starts: Callable[[Array], list[Array]]
    low: tuple[float, ...]
    high: tuple[float, ...]


def _cone(h: float, shape: Array, end: float, _tilt: float) -> Array:
    """Give a cone of length l with a ball of radius r: (l, r) in half widths."""
    length, radius = shape
    half_angle = np.arctan2(1.0, length)
    normal = np.pi / 2 - half_angle
    turn = np.linspace(-normal, normal, ARC_POINTS)
    arc = radius * np.column_stack([np.sin(turn), 1 - np.cos(turn)])
    sharp = radius * (1 / np.sin(half_angle) - 1)  # how far the sharp apex lies in front
    base = max(length - sharp, arc[-1, 1] + 1e-6)
    wide = (base + sharp) / length
    points = np.concatenate(
        [[[-wide, end / h], [-wide, base]], arc, [[wide, base], [wide, end / h]]]
    )
    return np.asarray(h * points)


def _rim(h: float, shape: Array, tilt: float, angles: Array) -> Array:
    """Give points (n, 2) of a bevel's rim at angles from its apex about the axis."""
    cot, azimuth = shape
    x = np.cos(angles - azimuth)
    return np.asarray(
        h * np.column_stack([x, cot * (1 - np.cos(angles)) + tilt * np.sin(angles - azimuth)])
    )


def _bevel(h: float, shape: Array, end: float, tilt: float) -> Array:
    """Give a bevelled cylinder: (cot of the bevel's angle, azimuth of the apex against x)."""
    azimuth = shape[1]
    arc = _rim(h, shape, tilt, _LEFT * (np.pi - azimuth) + _RIGHT * azimuth)
    return np.concatenate([[[-h, end]], arc, [[h, end]]])


def _wedge(h: float, shape: Array, end: float, _tilt: float) -> Array:
    """Give a point at x with two straight flanks: (x, left length, right length)."""
    x, left, right = shape
    points = [[-1, end / h], [-1, left], [x, 0.0], [1, right], [1, end / h]]
    return np.asarray(h * np.array(points))


def _cone_depth(h: float, shape: Array) -> float:
    return float(h * max(shape[0] - shape[1] * (np.hypot(1, shape[0]) - 1), 0.0))


def _wedge_depth(h: float, shape: Array) -> float:
    return float(h * max(shape[1], shape[2]))


def _bevel_facet(h: float, shape: Array, tilt: float) -> Array:
    return _rim(h, shape, tilt, _ROUND)


def _bevel_apex(h: float, shape: Array, tilt: float) -> tuple[float, float]:
    x, z = _rim(h, shape, tilt, np.zeros(1))[0]
    return float(x), float(z)


def _no_facet(_h: float, _shape: Array, _tilt: float) -> Array:
    return np.zeros((0, 2))


def _bevel_starts(begin: Array) -> list[Array]:
    """Give bevels that reach as far up the sides as is seen, for some places of the apex.

    A bevel's edge leaves the shaft's side tangentially: it is seen only `HIDDEN_RAD` further on.
    """
    x, _, _, left, right = begin
    starts = []
    for off in (-0.3, 0.0, 0.3):
        azimuth = float(np.clip(np.arccos(np.clip(x, -0.98, 0.98)) + off, 0.1, np.pi - 0.1))
        seen = [
            (length, 1 - np.cos(max(angle - HIDDEN_RAD, 0.2)))
            for length, angle in ((left, np.pi - azimuth), (right, azimuth))
        ]
        length, share = max(seen)
        starts.append(np.array([float(np.clip(length / share, 0.3, 11.0)), azimuth]))
    return starts


def _wedge_starts(begin: Array) -> list[Array]:
    return [np.array([begin[0], max(begin[1], 0.2), max(begin[2], 0.2)])]


def _cone_starts(begin: Array) -> list[Array]:
    """Give cones as long as is seen, and longer ones: their flanks are seen late."""
    length = max((begin[1] + begin[2]) / 2, 0.3)
    return [np.array([length * longer]) for longer in (1.0, LONGER)]


def _round_starts(begin: Array) -> list[Array]:
    return [np.array([max((begin[1] + begin[2]) / 2, 0.3), radius]) for radius in (0.1, 0.4)]


CONE = Family(
    "cone",
    lambda h, shape, end, tilt: _cone(h, np.array([shape[0], 0.0]), end, tilt),
    lambda _h, _shape, _tilt: (0.0, 0.0),
    lambda h, shape: float(h * shape[0]),
    None,
    _cone_starts,
    (0.02,),
    (20.0,),
)
ROUND = Family(
    "round",
    _cone,
    lambda _h, _shape, _tilt: (0.0, 0.0),
    _cone_depth,
    None,
    _round_starts,
    (0.02, 0.0),
    (20.0, 0.9),
)
WEDGE = Family(
    "wedge",
    _wedge,
    lambda h, shape, _tilt: (float(h * shape[0]), 0.0),
    _wedge_depth,
    None,
    _wedge_starts,
    (-1.0, 0.0, 0.0),
    (1.0, 20.0, 20.0),
)
BEVEL = Family(
    "bevel",
    _bevel,
    _bevel_apex,
    lambda h, shape: float(2 * h * shape[0]),
    _bevel_facet,
    _bevel_starts,
    (0.1, 0.0),
    (12.0, np.pi),
)
BEVEL_AWAY = Family(
    "bevel_away",
    lambda h, shape, end, tilt: _bevel(h, shape, end, -tilt),
    lambda h, shape, tilt: _bevel_apex(h, shape, -tilt),
    BEVEL.depth,
    _no_facet,
    _bevel_starts,
    BEVEL.low,
    BEVEL.high,
)
FAMILIES = {family.name: family for family in (CONE, ROUND, WEDGE, BEVEL, BEVEL_AWAY)}


def usual_depth(family: Family, begin: Array) -> float:
    """Give how far up a tip goes as edges suggest it, half widths: the median of its starts."""
    return float(np.median([family.depth(1.0, shape) for shape in family.starts(begin)]))
