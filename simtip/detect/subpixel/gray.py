"""Images of any kind to gray values for the sub-pixel detector: equal weights, nothing rounded."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.gray import Gray, check_full_scale, check_image
from simtip.detect.protocol import Image

EVERYWHERE = slice(None), slice(None)
"""The whole of an image."""


def coarse_gray(image: Image, full_scale: int | None) -> Gray:
    """Give an 8-bit gray image (H, W) in which to look for edges."""
    check_image(image)
    check_full_scale(image, full_scale)
    if image.dtype == np.uint16:
        image = np.clip(image * (255 / (full_scale or 65535)) + 0.5, 0, 255).astype(np.uint8)
    if image.ndim == 2:
        return np.ascontiguousarray(image)
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY), np.uint8)


def mean_gray(
    image: Image, full_scale: int | None, part: tuple[slice, slice] = EVERYWHERE
) -> NDArray[np.float32]:
    """Give the mean of the channels (H, W), 0 to 255, in a part of the image; else 0.

    Every channel shows the needle, each with noise of its own: equal weights leave least noise
    where the background is white.
    """
    scale = 1.0 if image.dtype == np.uint8 else 255 / (full_scale or 65535)
    values = np.zeros(image.shape[:2], np.float32)
    seen = image[part]
    if image.ndim == 2:
        np.multiply(seen, np.float32(scale), out=values[part], casting="unsafe")
        return values
    red, green, blue = cv2.split(np.ascontiguousarray(seen))
    total = cv2.add(cv2.add(red, green, dtype=cv2.CV_32F), blue, dtype=cv2.CV_32F)
    np.multiply(total, np.float32(scale / 3), out=values[part])
    return values
