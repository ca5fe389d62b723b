"""A region of an image in which a detector looks, with results in pixels of the whole image."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from simtip.detect.observation import TipObservation
from simtip.detect.protocol import ConfiguredDetector, Image, for_region
from simtip.errors import InputError

REMEDY = "write x,y,w,h in px: the left column, the upper row, width and height"


@dataclass(frozen=True)
class Region:
    """A rectangle of whole pixels.

    Attributes
    ----------
    u0, v0
        Its top-left pixel.
    width, height
        px, 1 or more.
    """

    u0: int
    v0: int
    width: int
    height: int

    def __str__(self) -> str:
        """Write it as `parse_region` reads it."""
        return f"{self.u0},{self.v0},{self.width},{self.height}"

    def check(self, shape: tuple[int, ...], *, file: str | Path | None = None) -> None:
        """Raise `InputError` if it reaches outside of an image (from a file) of that shape."""
        height, width = shape[:2]
        if self.u0 + self.width > width or self.v0 + self.height > height:
            raise InputError(
                f"{self} reaches outside of the image of {width} x {height} px",
                file=file,
                remedy=f"stay within x 0 to {width - 1} and y 0 to {height - 1}",
            )


def parse_region(text: str) -> Region:
    """Read ``x,y,w,h``.

    Raises
    ------
    InputError
        These are not four whole numbers, a side is 0, or it begins outside of every image.
    """
    try:
        u0, v0, width, height = (int(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{text!r} is no region", remedy=REMEDY) from None
    if width < 1 or height < 1:
        raise InputError(f"{text!r} is empty", remedy=REMEDY)
    if u0 < 0 or v0 < 0:
        raise InputError(f"{text!r} begins outside of the image", remedy=REMEDY)
    return Region(u0, v0, width, height)


def within(
    detector: ConfiguredDetector, region: Region | None, *, of_whole: bool = True
) -> ConfiguredDetector:
    """Let a detector see a region alone; None is the whole image.

    `of_whole` says that the detector was set up for the whole image, not for the region: places
    among its parameters are moved.

    The tip counts in pixels of the whole image. Layers, and pixels that a reason names, stay those
    of the region.

    Raises
    ------
    InputError
        By the detector that is given: the region reaches outside of the image.
    """
    if region is None:
        return detector

    def detect(image: Image, *, layers: bool = False) -> TipObservation:
        region.check(image.shape)
        rows = slice(region.v0, region.v0 + region.height)
        columns = slice(region.u0, region.u0 + region.width)
        look = for_region(detector, region.u0, region.v0, image.shape) if of_whole else detector
        seen = look(image[rows, columns], layers=layers)
        if seen.tip_px is None:
            return replace(seen, reason=f"{seen.reason} [within the region {region}]")
        return replace(seen, tip_px=seen.tip_px + np.array([region.u0, region.v0]))

    return detect
