"""Images of any supported kind to gray values between 0 and 1."""

from __future__ import annotations

from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError

Gray: TypeAlias = NDArray[np.float32]

LUMA_WEIGHTS = (0.299, 0.587, 0.114)
"""R, G, B weights of ITU-R BT.601."""

TAILS = (0.1, 99.9)
"""Percentiles that become black and white."""

FAINTEST_DN = 3
"""Least distance of those, in steps of the image, that shows anything."""


def to_gray(image: NDArray[Any]) -> Gray | None:
    """Weigh the colours, and stretch to 0 to 1: what is brighter or darker goes beyond.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16. Not changed.

    Returns
    -------
    Array or None
        (H, W), or None if the image is uniform.

    Raises
    ------
    InputError
        Another shape or type, or no pixel at all.
    """
    if image.dtype not in (np.uint8, np.uint16):
        raise InputError(f"an image of {image.dtype} is neither 8 nor 16 bit")
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3) or not image.size:
        raise InputError(f"an image of shape {image.shape} is neither (H, W) nor (H, W, 3)")
    value = image.astype(np.float32)
    if value.ndim == 3:
        value = value @ np.asarray(LUMA_WEIGHTS, dtype=np.float32)
    low, high = np.percentile(value, TAILS)
    if high - low < FAINTEST_DN:
        return None
    return np.ascontiguousarray((value - np.float32(low)) / np.float32(high - low))


def to_8_bit(gray: Gray) -> NDArray[np.uint8]:
    """Cut to 0 to 1 and count in 8 bits, for detectors that know no other."""
    return np.asarray(np.clip(gray * 255 + 0.5, 0, 255), dtype=np.uint8)


def resized(gray: Gray, scale: float) -> Gray:
    """Shrink (by area) or enlarge; `original_pixels` undoes it for coordinates."""
    if scale == 1:
        return gray
    size = [max(1, round(n * scale)) for n in gray.shape[::-1]]
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(gray, size, interpolation=how), dtype=np.float32)


def original_pixels(pixels: NDArray[np.float64], small: Gray, gray: Gray) -> NDArray[np.float64]:
    """Map pixels (n, 2) of a resized image to the image itself: edges meet, not pixel centres."""
    ratio = np.array(gray.shape[::-1]) / np.array(small.shape[::-1])
    result: NDArray[np.float64] = (pixels + 0.5) * ratio - 0.5
    return result
