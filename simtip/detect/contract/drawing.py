"""Needles, discs and lines drawn with the exact area that they cover of each pixel.

Small and on its own, so that the contract needs no renderer: pixels are unit squares about whole
(u, v), as everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.seeding import stream

SUB_ROWS = 16
"""A pixel's rows at which the covered length is worked out; along a row it is exact."""
BLUR_PX = 0.7
"""Standard deviation of the Gaussian that stands for the lens."""
NOISE_DN = 2.0


@dataclass(frozen=True)
class Needle:
    """A straight needle with a conical point, long enough to leave any picture.

    Attributes
    ----------
    tip_px
        u, v of the apex.
    degrees
        Direction from the tip to the hub, from +u towards +v; -90 is up, so that the tip is the
        lowest point.
    width_px, point_px
        Width of the shaft, and length of the point.
    """

    tip_px: tuple[float, float]
    degrees: float = -90.0
    width_px: float = 24.0
    point_px: float = 30.0

    @property
    def axis(self) -> Array:
        """Unit direction from the tip to the hub, (2,)."""
        angle = np.radians(self.degrees)
        return np.array([np.cos(angle), np.sin(angle)])

    @property
    def outline(self) -> Array:
        """Corners of the convex outline, (5, 2) u, v in px."""
        along, half = self.axis, self.width_px / 2
        across = np.array([-along[1], along[0]])
        places = [
            (0, 0),
            (self.point_px, half),
            (5000, half),
            (5000, -half),
            (self.point_px, -half),
        ]
        return np.array([np.array(self.tip_px) + a * along + b * across for a, b in places])


def disc(centre_px: ArrayLike, radius_px: float) -> Array:
    """Give the corners of a disc, as a polygon of 32, (32, 2)."""
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    return np.asarray(centre_px, float) + radius_px * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    )


def line(start_px: ArrayLike, end_px: ArrayLike, width_px: float) -> Array:
    """Give the corners of a straight stroke, (4, 2)."""
    start, end = np.asarray(start_px, float), np.asarray(end_px, float)
    along = (end - start) / np.linalg.norm(end - start)
    half = width_px / 2 * np.array([-along[1], along[0]])
    return np.array([start + half, end + half, end - half, start - half])


def coverage(shape: tuple[int, int], corners: Array) -> Array:
    """Give how much of each pixel a convex polygon (n, 2) covers, (H, W), 0 to 1."""
    covered = np.zeros(shape)
    low = np.clip(np.floor(corners.min(axis=0)), 0, (shape[1], shape[0])).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0)) + 1, 0, (shape[1], shape[0])).astype(int)
    (u0, v0), (u1, v1) = low, high
    if u0 < u1 and v0 < v1:
        covered[v0:v1, u0:u1] = _coverage((v1 - v0, u1 - u0), corners - low)
    return covered


def _coverage(shape: tuple[int, int], corners: Array) -> Array:
    height, width = shape
    v = (np.arange(height * SUB_ROWS) + 0.5) / SUB_ROWS - 0.5
    left, right = np.full(len(v), np.inf), np.full(len(v), -np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        crossed = (v >= min(a[1], b[1])) & (v < max(a[1], b[1]))
        if not crossed.any():
            continue
        u = a[0] + (v[crossed] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
        left[crossed] = np.minimum(left[crossed], u)
        right[crossed] = np.maximum(right[crossed], u)
    missed = left > right
    left[missed] = right[missed] = 0.0
    # what of the line lies left of each pixel edge: differences are what lies in each pixel
    before = np.clip(np.arange(width + 1) - 0.5, left[:, None], right[:, None])
    lengths: Array = np.diff(before, axis=1).reshape(height, SUB_ROWS, width).mean(axis=1)
    return lengths


def picture(
    shape: tuple[int, int],
    things: Sequence[Array],
    *,
    background_dn: float = 200.0,
    dark_dn: float = 40.0,
    name: str = "picture",
) -> NDArray[np.uint8]:
    """Draw dark convex things on a bright ground, with a lens's blur and a camera's noise.

    Parameters
    ----------
    shape
        (H, W), px.
    things
        Outlines, (n, 2) each.
    background_dn, dark_dn
        Levels, 8-bit DN.
    name
        Of the noise: equal names give equal noise.
    """
    covered = np.zeros(shape)
    for thing in things:
        covered = np.maximum(covered, coverage(shape, thing))
    light = background_dn + (dark_dn - background_dn) * covered
    blurred = np.asarray(cv2.GaussianBlur(light, (0, 0), BLUR_PX))
    noise = stream(0, "detector contract", name).normal(0.0, NOISE_DN, shape)
    return np.clip(np.rint(blurred + noise), 0, 255).astype(np.uint8)
