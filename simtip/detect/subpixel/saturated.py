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
"""Of that, what the ground beside the needle may have in a row: of a brighter one only the brighter
pixels would be taken away."""

GROUND_PX = (3, 12)
"""From the needle's edges, where the ground is looked at."""

RIM_PX = 1
"""What is full so near to an edge may be the ground's."""

STREAK_SHARE = 0.5
"""Of the shaft's rows: a streak at full scale in so many is left out of all of them. Where it is
just below, its brightness changes too steeply to be told from a neighbour's."""

STREAK_PX = 2
"""How far beside it it may go on along the tip."""


def without_saturated(image: NDArray[np.float32], traced: Trace, end: float) -> NDArray[np.float32]:
    """Give a gray image (H, W) with NaN where a needle is at full scale, and next to that.

    And all along a streak of that. A ground at full scale stays as it is: it may be taken for what
    it shows; and so does a tip's facet, which shows where the tip ends.

    Parameters
    ----------
    image
        Turned.
    traced
        The needle in it.
    end
        Row before which its shaft ends.
    """
    half = round(traced.width_px / 2)
    columns = _columns(traced, half + GROUND_PX[1], image.shape[1])
    v = traced.rows[:, None]
    beside = np.abs(np.arange(columns.shape[1]) - columns.shape[1] // 2) > half + GROUND_PX[0]
    plain = np.median(image[v, columns[:, beside]], axis=1) <= MOST_LEVEL * FULL_DN
    within = GROUND_PX[1] + RIM_PX
    columns = columns[:, within:-within]
    along, shaft = image[v, columns] >= FULL_DN, traced.rows < end
    if not (along.any() and (shaft & plain).any()):
        return image
    streak = along[shaft & plain].mean(axis=0) > STREAK_SHARE
    near = np.convolve(streak, np.ones(2 * STREAK_PX + 1), "same") > 0
    narrow = along.sum(axis=1) <= streak.sum() + 2 * STREAK_PX
    left_out = np.zeros(image.shape, np.uint8)
    left_out[v, columns] = np.where(
        shaft[:, None], (along & plain[:, None]) | streak, along & near & narrow[:, None]
    )
    wide = cv2.dilate(left_out, np.ones((3, 3), np.uint8))
    return np.where(wide, np.float32(np.nan), image)


def _columns(traced: Trace, reach: int, width: int) -> NDArray[np.intp]:
    """Give the columns (rows, 2 reach + 1) to both sides of a needle's middle."""
    middle = np.rint(traced.centre[0] + traced.centre[1] * traced.rows).astype(np.intp)
    columns = middle[:, None] + np.arange(-reach, reach + 1)
    return np.asarray(np.clip(columns, 0, width - 1), np.intp)
