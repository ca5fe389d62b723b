"""Pixels at full scale: they say that it is bright there, and no more.

Polished metal before a lamp is brighter than a camera can tell. A brightness fitted to what is left
of it would be wrong beside it, too, and so the needle's edges.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.trace import Trace

FULL_SCALE = 255.0

FULL_DN = 250.0
"""Gray value that counts as full scale: channels and pixels fill up a little unevenly."""

MOST_LEVEL = 0.9
"""Of that, what a background may have: of a brighter one it would take the brighter pixels only."""


STREAK_SHARE = 0.5
"""Of the shaft's rows: a streak at full scale in so many is left out of all of them. Where it is
just below, its brightness changes too steeply to be told from a neighbour's."""

STREAK_PX = 2
"""How far beside it it may go on along the tip."""


def without_saturated(image: NDArray[np.float32], traced: Trace, end: float) -> NDArray[np.float32]:
    """Give a gray image (H, W) with NaN at full scale and next to it, and along a streak of that.

    Before a background that is itself nearly at full scale the image stays as it is: it may be
    taken for what it shows.

    Parameters
    ----------
    image
        Turned.
    traced
        The needle in it.
    end
        Row before which its shaft ends.
    """
    full = image >= FULL_DN
    if traced.level > MOST_LEVEL * FULL_DN or not full.any():
        return image
    v = traced.rows
    reach = int(traced.width_px)
    columns = np.rint(traced.centre[0] + traced.centre[1] * v).astype(np.intp)[:, None]
    columns = np.clip(columns + np.arange(-reach, reach + 1), 0, image.shape[1] - 1)
    along = full[v[:, None], columns]
    shaft = v < end
    streak = along[shaft].mean(axis=0) > STREAK_SHARE
    near = np.convolve(streak, np.ones(2 * STREAK_PX + 1), "same") > 0
    left_out = np.zeros(image.shape, np.uint8)
    left_out[v[:, None], columns] = np.where(shaft[:, None], along | streak, along & near)
    wide = cv2.dilate(left_out, np.ones((3, 3), np.uint8))
    return np.where(wide, np.float32(np.nan), image)
