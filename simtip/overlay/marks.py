"""The marks: a cross, a ring and a line, painted where they belong to a hundredth of a pixel.

Colours are those of Okabe and Ito (2008, "Color universal design"), which colour-blind people tell
apart, and each mark has a shape of its own besides.

Marks are painted from their exact distance to each pixel centre. OpenCV's anti-aliased lines are
up to 0.15 px off the place asked for, and wider than asked (measured with OpenCV 5.0).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array

Picture: TypeAlias = NDArray[np.uint8]
Color: TypeAlias = tuple[int, int, int]

TRUE_COLOR: Color = (0, 114, 178)
"""Blue: the true tip, a cross with an open centre."""
DETECTED_COLOR: Color = (213, 94, 0)
"""Vermilion: the detected tip, a ring with a dot in its centre."""
LINE_COLOR: Color = (204, 121, 167)
"""Reddish purple: the epipolar line."""
WHITE: Color = (255, 255, 255)


@dataclass(frozen=True, eq=False)
class Marks:
    """What is to be drawn, px of the picture drawn on: points, a line and a direction.

    The line is scaled so that a u + b v + c is the distance in px, the axes to length 1.
    """

    true: Array | None = None
    detected: Array | None = None
    line: Array | None = None
    axis: Array | None = None
    detected_axis: Array | None = None

    def tips(self, shape: tuple[int, ...]) -> list[Array]:
        """Give the tips that lie in an image of this shape, the true one first."""
        return [p for p in (self.true, self.detected) if p is not None and is_inside(p, shape)]


def is_inside(point: Array, shape: tuple[int, ...]) -> bool:
    """Say whether a point lies on the image, whose pixels reach 0.5 px around their centres."""
    return bool(-0.5 <= point[0] < shape[1] - 0.5 and -0.5 <= point[1] < shape[0] - 0.5)


def draw_marks(picture: Picture, marks: Marks, *, reach: float, stroke: float, halo: float) -> None:
    """Draw the lines, the true tip and the detected one, as far as there are such.

    Sizes are in px: how far the cross reaches from its centre, the breadth of its strokes, and
    that of the white rim around.
    """
    gap, radius = 0.4 * reach, 0.35 * reach

    def cross(x: Array, y: Array) -> Array:
        x, y = np.abs(x), np.abs(y)
        level = np.hypot(np.maximum(0, np.maximum(gap - x, x - reach)), y)
        upright = np.hypot(np.maximum(0, np.maximum(gap - y, y - reach)), x)
        return np.asarray(np.minimum(level, upright) - stroke / 2)

    def ring(x: Array, y: Array) -> Array:
        r = np.hypot(x, y)
        return np.asarray(np.minimum(np.abs(r - radius) - stroke / 2, r - 0.75 * stroke))

    if marks.line is not None:
        a, b, c = marks.line
        v, u = np.ogrid[: picture.shape[0], : picture.shape[1]]
        off_line = np.abs(a * u + (b * v + c)) - max(0.5, 0.4 * stroke)
        _paint(picture, off_line, LINE_COLOR, halo, 0.4)
    if marks.detected is not None and marks.detected_axis is not None:
        (u0, v0), (a, b) = marks.detected, marks.detected_axis
        v, u = np.ogrid[: picture.shape[0], : picture.shape[1]]
        x, y = u - u0, v - v0
        beyond_ring = np.maximum(0, radius + stroke - (a * x + b * y))
        off_axis = np.hypot(a * y - b * x, beyond_ring) - max(0.5, 0.3 * stroke)
        _paint(picture, off_axis, DETECTED_COLOR, 0, 0)
    for point, shape, color in (
        (marks.true, cross, TRUE_COLOR),
        (marks.detected, ring, DETECTED_COLOR),
    ):
        if point is not None:
            _paint_around(picture, point, reach + stroke + halo + 1, shape, color, halo)


def blend(patch: Picture, color: Color, alpha: ArrayLike) -> None:
    """Mix a colour into a view of a picture, in place."""
    a = np.asarray(alpha, dtype=np.float64)[..., None]
    patch[...] = np.rint(patch * (1 - a) + np.array(color, dtype=np.float64) * a).astype(np.uint8)


def _paint_around(
    picture: Picture,
    centre: Array,
    far: float,
    shape: Callable[[Array, Array], Array],
    color: Color,
    halo: float,
) -> None:
    """Paint a shape, given by the signed distance to it, that ends before `far`, px."""
    u0, v0 = (max(0, math.floor(c - far)) for c in centre)
    u1, v1 = (max(0, math.ceil(c + far) + 1) for c in centre)
    patch = picture[v0:v1, u0:u1]
    v, u = np.indices(patch.shape[:2])
    _paint(patch, shape(u + (u0 - centre[0]), v + (v0 - centre[1])), color, halo, 0.85)


def _paint(patch: Picture, outside: Array, color: Color, halo: float, halo_alpha: float) -> None:
    """Paint all but what is `outside` (signed distance, px), and a white rim around it."""
    near = np.nonzero(outside - halo < 0.5)
    pixels = patch[near]
    # A pixel is covered by 0.5 less the distance of its centre from the edge.
    blend(pixels, WHITE, halo_alpha * np.clip(0.5 + halo - outside[near], 0, 1))
    blend(pixels, color, np.clip(0.5 - outside[near], 0, 1))
    patch[near] = pixels
