"""Images of any supported kind to 8-bit gray."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from simtip.detect.parameters import bad_value
from simtip.detect.protocol import Image
from simtip.errors import InputError
from simtip.geometry import Array

Gray: TypeAlias = NDArray[np.uint8]

LUMA_WEIGHTS = (0.299, 0.587, 0.114)
"""R, G, B weights of ITU-R BT.601, the usual "weighted average"."""

HALF = 0.5 + 1e-9
"""For rounding: 1e-9 keeps exact halves, which the weights cannot represent, on the upper side."""

STRIP_ROWS = 32
"""Rows worked out at a time, so that their numbers stay in the processor's cache."""


def to_gray(
    image: Image,
    weights: tuple[float, float, float] = LUMA_WEIGHTS,
    full_scale: int | None = None,
) -> Gray:
    """Convert to 8-bit gray by a weighted average, rounded once, halves up.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16, of any memory layout. Not changed.
    weights
        Of R, G and B, summing to 1. Not used on a gray image.
    full_scale
        For uint16 only: the value that becomes 255, e.g. 1023 or 4095 for 10- or 12-bit data.
        None is 65535, which divides by 257.

    Returns
    -------
    NDArray[np.uint8]
        (H, W), contiguous.

    Raises
    ------
    InputError
        Another shape or type, no pixel at all, a `full_scale` with an 8-bit image, or a pixel
        above `full_scale`.
    """
    check_image(image)
    check_full_scale(image, full_scale)
    if image.ndim == 2 and image.dtype == np.uint8:
        return np.array(image, dtype=np.uint8, order="C")
    gray = np.empty(image.shape[:2], dtype=np.uint8)
    scale = 255 / white_of(image, full_scale)
    for first in range(0, len(image), STRIP_ROWS):
        value = _average(image[first : first + STRIP_ROWS], weights)
        value *= scale
        value += HALF
        gray[first : first + STRIP_ROWS] = value  # the cast cuts off the fraction
    return gray


def _average(image: Image, weights: tuple[float, float, float]) -> Array:
    """Average the channels, (H, W), in the order R, G, B."""
    if image.ndim == 2:
        return image.astype(np.float64)
    value: Array = image[..., 0] * np.float64(weights[0])
    value += image[..., 1] * np.float64(weights[1])
    value += image[..., 2] * np.float64(weights[2])
    return value


def level(dn: int, white: int) -> int:
    """Give the gray value of a gray pixel, as `to_gray` does."""
    return math.floor(dn * (255 / white) + HALF)


def white_of(image: Image, full_scale: int | None) -> int:
    """Give the DN that becomes 255."""
    return 255 if image.dtype == np.uint8 else full_scale or 65535


def check_image(image: Image) -> None:
    """Raise `InputError` for what is not an image of a supported kind with at least one pixel."""
    if not isinstance(image, np.ndarray) or image.dtype not in (np.uint8, np.uint16):
        kind = image.dtype if isinstance(image, np.ndarray) else type(image).__name__
        raise InputError(f"the image is {kind}", remedy="give an array of uint8 or uint16")
    if image.size == 0 or not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)):
        shape = " x ".join(map(str, image.shape))
        raise InputError(
            f"the image has the shape {shape or 'of a number'}",
            remedy="give (H, W) gray or (H, W, 3) RGB with at least one pixel",
        )


def check_full_scale(image: Image, full_scale: int | None) -> None:
    """Raise `InputError` for a white level that an image cannot have."""
    if full_scale is None:
        return
    if image.dtype == np.uint8:
        raise bad_value("full_scale", "the image has 8 bits", "leave full_scale out")
    if (brightest := int(image.max())) > full_scale:
        raise bad_value(
            "full_scale",
            f"a pixel of {brightest} is above {full_scale}",
            "give the white level of the camera's bit depth",
        )
