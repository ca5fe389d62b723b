"""The part of a two-level image that holds all its dark pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from simtip.detect.gray import Gray
from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class Patch:
    """A rectangle cut out of a two-level image; around it, everything is 255.

    Attributes
    ----------
    pixels
        (h, w) uint8 of 0 (needle) and 255.
    u, v
        Of its upper left pixel in the whole image, px, both even.
    """

    pixels: Gray
    u: int = 0
    v: int = 0

    def shrunk(self, margin_px: int) -> Patch:
        """Cut closer, leaving a margin about the dark pixels where there is room for one.

        A patch without a dark pixel stays as it is. The corner stays even: OpenCV numbers
        components in the order of blocks of 2 x 2 pixels, and so numbers them as in the whole.
        """
        u, v, width, height = cv2.boundingRect(cv2.bitwise_not(self.pixels))
        if not width:
            return self
        first_u, first_v = (max(c - margin_px, 0) // 2 * 2 for c in (u, v))
        part = self.pixels[first_v : v + height + margin_px, first_u : u + width + margin_px]
        return Patch(np.ascontiguousarray(part), self.u + first_u, self.v + first_v)

    def outside(self, point_px: Array) -> Array:
        """Give a point (2,) of the patch in the whole image's pixels."""
        moved: Array = point_px + np.array([self.u, self.v])
        return moved
