"""The colour mosaic: one channel for each pixel, and the two others made up from neighbours."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.sensor.readout import Image

RGGB = np.array([[0, 1], [1, 2]])
"""Channel of the pixel at (row, column) modulo 2 of the full sensor: red, green, blue."""

_DEMOSAIC = (
    (cv2.COLOR_BayerRGGB2RGB, cv2.COLOR_BayerGRBG2RGB),
    (cv2.COLOR_BayerGBRG2RGB, cv2.COLOR_BayerBGGR2RGB),
)


def tile(origin: tuple[int, int]) -> NDArray[np.intp]:
    """Give the (2, 2) channels at the corner of a region that begins at x, y of the sensor."""
    x, y = origin
    return np.roll(RGGB, (-(y % 2), -(x % 2)), axis=(0, 1)).astype(np.intp)


def sample(planes: NDArray[Any], origin: tuple[int, int]) -> NDArray[Any]:
    """Take from (H, W, 3) the one channel that each pixel has, (H, W)."""
    raw = np.empty(planes.shape[:2], dtype=planes.dtype)
    for (row, column), channel in np.ndenumerate(tile(origin)):
        raw[row::2, column::2] = planes[row::2, column::2, channel]
    return raw


def sample_indices(flat: NDArray[np.intp], width: int, origin: tuple[int, int]) -> NDArray[np.intp]:
    """Take from flat indices into (H, W, 3) those that `sample` takes, as indices into (H, W)."""
    pixel, channel = np.divmod(flat, 3)
    row, column = np.divmod(pixel, width)
    kept: NDArray[np.intp] = pixel[tile(origin)[row % 2, column % 2] == channel]
    return kept


def demosaic(raw: Image, origin: tuple[int, int]) -> Image:
    """Give (H, W, 3) RGB by OpenCV's bilinear demosaicing; a pixel keeps its own channel.

    The outermost pixels are copied from their neighbours.

    Parameters
    ----------
    raw
        (H, W) DN, at least 3 by 3.
    origin
        x, y on the full sensor of its first pixel.
    """
    if min(raw.shape) < 3:
        raise ValueError(f"a mosaic needs 3 x 3 pixels at least, not {raw.shape}")
    x, y = origin
    rgb: Image = cv2.cvtColor(raw, _DEMOSAIC[y % 2][x % 2])  # type: ignore[assignment]  # OpenCV keeps the type; its stubs do not say so
    return rgb
