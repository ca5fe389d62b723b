"""Threshold of an image of any kind by its gray value, without working out every gray value."""

from __future__ import annotations

import math
from bisect import bisect_left

import cv2
import numpy as np

from simtip.detect.gray import (
    LUMA_WEIGHTS,
    Gray,
    check_full_scale,
    check_image,
    level,
    to_gray,
    white_of,
)
from simtip.detect.protocol import Image

SLACK_DN = {np.dtype(np.uint8): 1, np.dtype(np.uint16): 8}
"""How far OpenCV's weighted average may be off, in DN of the image.

Its fixed-point weights have 14 bits or more, each off by at most 2^-15: 3 * 65535 * 2^-15 = 6.0,
and 0.02 at 8 bits; floating-point ones are off by less. Rounding adds 0.5.
"""


def binarised(
    image: Image,
    threshold: int,
    weights: tuple[float, float, float] = LUMA_WEIGHTS,
    full_scale: int | None = None,
) -> Gray:
    """Give 255 where the gray value is at or above the threshold, and 0 below.

    Equal, bit by bit, to ``binarise(to_gray(image, weights, full_scale), threshold)``. The average
    of the channels comes from OpenCV; where that is too close to the threshold to tell, from
    `to_gray`.

    Parameters
    ----------
    image, weights, full_scale
        As in `to_gray`.
    threshold
        Gray value of 8 bits, 1 to 255.

    Returns
    -------
    NDArray[np.uint8]
        (H, W), contiguous.

    Raises
    ------
    InputError
        As `to_gray`.
    """
    check_image(image)
    check_full_scale(image, full_scale)
    white = white_of(image, full_scale)
    image = np.ascontiguousarray(image)
    if image.ndim == 2:
        least = bisect_left(range(white + 1), threshold, key=lambda dn: level(dn, white))
        return _at_least(image, least)
    average = _average(image, weights)
    limit = (threshold - 0.5) * white / 255
    slack = SLACK_DN[image.dtype]
    low, high = math.floor(limit) - slack, math.ceil(limit) + slack
    binary = _at_least(average, low)
    unsure = np.flatnonzero((binary & (average <= high)).view(np.bool_))
    if len(unsure) > average.size // 8:
        return _at_least(to_gray(image, weights, full_scale), threshold)
    if len(unsure) == 0:
        return binary
    gray = to_gray(image.reshape(1, -1, 3)[:, unsure], weights, full_scale)
    binary.reshape(-1)[unsure] = _at_least(gray, threshold)
    return binary


def _average(image: Image, weights: tuple[float, float, float]) -> Image:
    """Average the channels to within `SLACK_DN`, (H, W) of the image's type."""
    if weights == LUMA_WEIGHTS:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), dtype=image.dtype)
    row = np.array([weights], dtype=np.float32)
    return np.asarray(cv2.transform(image, row), dtype=image.dtype)


def _at_least(image: Image, least: int) -> Gray:
    return (image >= least).view(np.uint8) * np.uint8(255)
