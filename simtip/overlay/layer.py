"""A detector's intermediate image as a small picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.overlay.marks import Picture

LONGEST_PX = 800


def layer_picture(layer: NDArray[np.generic], longest_px: int = LONGEST_PX) -> Picture | None:
    """Make a picture of an array, no longer on either side than `longest_px`.

    Parameters
    ----------
    layer
        (H, W) or (H, W, 3) of uint8, shown as it is, or of bool or any other real numbers, spread
        from the least (black) to the greatest (white); what is not finite is black.
    longest_px
        Longest side; smaller layers keep their size.

    Returns
    -------
    ndarray or None
        uint8, or None for an array that is no picture.
    """
    if layer.ndim not in (2, 3) or layer.shape[2:] not in ((), (3,)) or layer.size == 0:
        return None
    if layer.dtype.kind not in "buif":
        return None
    shades = layer if layer.dtype == np.uint8 else _spread(layer)
    scale = longest_px / max(layer.shape[:2])
    if scale >= 1:
        return np.ascontiguousarray(shades, dtype=np.uint8)
    size = tuple(max(1, round(side * scale)) for side in layer.shape[1::-1])
    small = cv2.resize(np.ascontiguousarray(shades), size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _spread(layer: NDArray[np.generic]) -> NDArray[np.uint8]:
    # Halved, so that no difference of two finite numbers is infinite.
    values = layer.astype(np.float64) / 2
    finite = np.isfinite(values)
    values[~finite] = values[finite].min() if finite.any() else 0
    least, span = values.min(), np.ptp(values)
    shades: NDArray[np.uint8] = np.rint((values - least) / (span or 1) * 255).astype(np.uint8)
    return shades
