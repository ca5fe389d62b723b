"""Follow a band along the image, row by row: where its edges are, and where it ends.

In the turned image the needle hangs tip down. What is found here is good to a pixel; the fits that
follow start from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.gray import Gray
from simtip.geometry import Array

ROOM_PX = 8
"""Beyond the needle's edges to either side."""

SMOOTH_ROWS = 5

EDGE_LEVEL = 0.25
"""Of the needle's usual contrast: an edge is where the outermost pixel exceeds it."""

END_LEVEL = 0.12
"""A row that nowhere reaches so much of the usual contrast shows no needle."""

CLEARER, MOST_LEVEL = 1.3, 0.45
"""Times that an edge and a needle's row exceed what is usual beside the needle, grain or print; and
the greatest part of the contrast that is asked for."""

END_ROWS = 6
"""So many of those in a row end it."""


@dataclass(frozen=True, eq=False)
class Trace:
    """A needle's edges in the turned image.

    Attributes
    ----------
    rows
        (n,) v of consecutive rows, from the hub's end to the last that shows the needle.
    left, right
        (n,) u of both edges, NaN where none was seen.
    centre
        u of the band's middle is ``centre[0] + centre[1] v``.
    slope
        du/dv of the band.
    width_px
        Of the shaft, along u.
    level, contrast
        Usual level of the background beside it and largest contrast within it, DN.
    at_top, at_bottom
        The needle reaches the image's border at the hub's end, at the tip's.
    """

    rows: NDArray[np.intp]
    left: Array
    right: Array
    centre: tuple[float, float]
    width_px: float
    level: float
    contrast: float
    at_top: bool
    at_bottom: bool


def trace(gray: Gray, centre: tuple[float, float], width_px: float) -> Trace | None:
    """Follow a band in the turned image; None if nothing is there.

    Parameters
    ----------
    gray
        (H, W) uint8, turned.
    centre
        ``u = centre[0] + centre[1] v`` along the band's middle.
    width_px
        Along u.
    """
    height, width = gray.shape
    half = width_px / 2
    reach = int(np.ceil(half)) + ROOM_PX
    v = np.arange(height)
    u = centre[0] + centre[1] * v
    inside = (u > half) & (u < width - 1 - half)
    if not inside.any():
        return None
    v, u = v[inside], u[inside]
    columns = np.rint(u).astype(np.intp)[:, None] + np.arange(-reach, reach + 1)
    seen = gray[v[:, None], np.clip(columns, 0, width - 1)].astype(np.float32)
    seen = np.asarray(cv2.blur(seen, (3, SMOOTH_ROWS), borderType=cv2.BORDER_REPLICATE), np.float32)
    offset = columns - u[:, None]
    level = _background(seen, half)
    dark: NDArray[np.float32] = np.subtract(level[:, None], seen, dtype=np.float32)
    np.abs(dark, out=dark)
    within = np.abs(offset) <= half + 4
    ground = float(np.median(np.where(within, 0, dark).max(axis=1)))
    dark[~within] = 0
    peak = dark.max(axis=1)
    usual = float(np.median(np.sort(peak)[-max(8, len(peak) // 3) :]))
    if usual < 4:
        return None
    uneven = min(CLEARER * ground, MOST_LEVEL * usual)
    first, last = _longest(peak >= max(END_LEVEL * usual, uneven))
    if last - first < 2 * width_px:
        return None
    part = slice(first, last + 1)
    strong = dark[part] >= max(EDGE_LEVEL * usual, uneven)
    any_seen = strong.any(axis=1)
    rows_u = columns[part].astype(np.float64)
    left = np.where(any_seen, rows_u[:, 0] + strong.argmax(axis=1) - 0.5, np.nan)
    right = np.where(any_seen, rows_u[:, -1] - strong[:, ::-1].argmax(axis=1) + 0.5, np.nan)
    return Trace(
        v[part],
        left,
        right,
        centre,
        width_px,
        float(np.median(level[part])),
        usual,
        bool(first == 0),
        bool(last == len(v) - 1),
    )


def _background(seen: NDArray[np.float32], half: float) -> NDArray[np.float32]:
    """Give the background's level (n,) beside the needle: the brighter of both sides' medians."""
    side = seen.shape[1]
    room = max(2, int((side - 2 * half) / 2) - 3)
    left, right = (np.median(part, axis=1) for part in (seen[:, :room], seen[:, side - room :]))
    level = np.maximum(left, right).astype(np.float32)[:, None]
    wide = np.asarray(cv2.blur(level, (1, 31), borderType=cv2.BORDER_REPLICATE), np.float32)
    return wide.reshape(-1)


def _longest(there: NDArray[np.bool_]) -> tuple[int, int]:
    """Give first and last of the longest stretch, gaps of fewer than `END_ROWS` closed."""
    where = np.flatnonzero(there)
    if not len(where):
        return 0, -1
    breaks = np.flatnonzero(np.diff(where) > END_ROWS)
    firsts = np.concatenate([[0], breaks + 1])
    lasts = np.concatenate([breaks, [len(where) - 1]])
    best = int(np.argmax(where[lasts] - where[firsts]))
    return int(where[firsts[best]]), int(where[lasts[best]])
