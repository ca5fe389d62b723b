"""Images of any supported kind to 8-bit gray."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from simtip.detect.parameters import bad_value
from simtip.detect.protocol import Image
from simtip.errors import InputError

Gray: TypeAlias = NDArray[np.uint8]

LUMA_WEIGHTS = (0.299, 0.587, 0.114)
"""R, G, B weights of ITU-R BT.601, the usual "weighted average"."""


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
    _check_full_scale(image, full_scale)
    white = 255 if image.dtype == np.uint8 else full_scale or 65535
    if image.ndim == 2 and image.dtype == np.uint8:
        return np.array(image, dtype=np.uint8, order="C")
    value = image.astype(np.float64)
    if image.ndim == 3:
        value = value[..., 0] * weights[0] + value[..., 1] * weights[1] + value[..., 2] * weights[2]
    # The 1e-9 keeps exact halves, which the weights cannot represent, on the upper side.
    gray = np.floor(value * (255 / white) + (0.5 + 1e-9)).astype(np.uint8)
    return np.ascontiguousarray(gray)


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


def _check_full_scale(image: Image, full_scale: int | None) -> None:
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
