"""Candidates for circles: dark patches with the outline of an ellipse."""

from __future__ import annotations

import cv2
import numpy as np

from simtip.find_target.candidates import Candidates
from simtip.find_target.gray import Gray, to_8_bit

WINDOWS_PX = (15, 41, 121)
"""Sides of the windows whose mean a dark patch lies below: for small, middling and large ones."""

DARKER = 6
"""By how much, of 255."""

LEAST_AREA_PX, LARGEST_PART = 12.0, 0.05
"""Least area of a patch, and most as part of the image."""

SLIMMEST = 0.25
"""Least ratio of an ellipse's axes."""

AREA_RATIO = (0.8, 1.25)
"""Of a patch to the ellipse that is fitted to its outline."""

UNROUND = (0.04, 0.6)
"""Most SD of an outline's radius, of the ellipse's: in itself, and px to be divided by its axis.
A square's is 0.1."""

MOST = 4000


def blobs(gray: Gray) -> Candidates:
    """Find candidates in (H, W) gray values."""
    image = cv2.GaussianBlur(to_8_bit(gray), (3, 3), 0)
    found: list[tuple[float, float, float]] = []
    for window in WINDOWS_PX:
        dark = cv2.adaptiveThreshold(
            image, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, window, DARKER
        )
        outlines, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        ellipses = [_ellipse(np.asarray(outline, np.int32), gray.size) for outline in outlines]
        found += [ellipse for ellipse in ellipses if ellipse is not None]
    kept = _different(np.array(found).reshape(-1, 3))
    return Candidates(kept[:, :2], np.full(len(kept), np.nan), kept[:, 2])


def _ellipse(
    outline: np.ndarray[tuple[int, ...], np.dtype[np.int32]], pixels: int
) -> tuple[float, float, float] | None:
    """Give u, v and the mean diameter of the ellipse that an outline is, if it is one."""
    area = cv2.contourArea(outline)
    if len(outline) < 8 or not LEAST_AREA_PX <= area <= LARGEST_PART * pixels:
        return None
    (u, v), axes, turn = cv2.fitEllipse(outline)
    small, large = min(axes), max(axes)
    if small < SLIMMEST * large:
        return None
    ratio = area / (np.pi / 4 * small * large)
    if not AREA_RATIO[0] <= ratio <= AREA_RATIO[1]:
        return None
    t = np.radians(turn)
    away = outline.reshape(-1, 2) - (u, v)
    along = away @ np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    radius = np.hypot(*(2 * along / axes).T)
    if radius.std() > UNROUND[0] + UNROUND[1] / small:
        return None
    return float(u), float(v), float(np.sqrt(small * large))


def _different(
    found: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Keep one, the largest, of those that share a centre (n, 3)."""
    found = found[np.argsort(-found[:, 2], kind="stable")]
    kept: dict[tuple[int, int], list[int]] = {}
    keep = []
    cell = 4.0
    for k, (u, v, size) in enumerate(found):
        home = (int(u // cell), int(v // cell))
        near = [
            j
            for du in (-1, 0, 1)
            for dv in (-1, 0, 1)
            for j in kept.get((home[0] + du, home[1] + dv), [])
        ]
        if all(np.hypot(*(found[j, :2] - (u, v))) > min(cell, 0.3 * size) for j in near):
            kept.setdefault(home, []).append(k)
            keep.append(k)
    return found[keep[:MOST]]
