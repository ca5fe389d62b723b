"""Find what may be a needle: two long, straight, parallel edges of opposite sense.

Line segments (von Gioi et al., LSD, 2010) of a reduced image are paired and pairs on one line are
joined. What lies between the edges does not matter: a highlight along the needle splits nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.gray import Gray
from simtip.geometry import Array

LARGE_PX = 800
"""Images with a longer side than this are reduced before segments are sought."""

PARALLEL_RAD = 0.05
"""Edges of one needle differ by less in direction."""

LEAST_OVERLAP = 1.5
"""Two edges lie beside each other for at least so many times their distance."""

MOST_SEGMENTS = 400
"""The longest ones, that are paired."""


ROOM_WIDTHS, ROOM_PX = 3.0, 100.0
"""Beside a band's middle, what of the image its needle is measured in."""


@dataclass(frozen=True, eq=False)
class Band:
    """A straight band between two parallel edges.

    Attributes
    ----------
    centre
        (2,) u, v of its middle.
    direction
        (2,) unit vector along it, of either sense.
    width_px
        Distance of the edges.
    length_px
        How far both edges were seen beside each other, all pieces together.
    score
        Length times contrast of the edges: what is probably a needle is first.
    """

    centre: Array
    direction: Array
    width_px: float
    length_px: float
    score: float

    def surroundings(self, shape: tuple[int, ...]) -> tuple[slice, slice]:
        """Give rows and columns of an image so high and wide in which the whole line's needle is.

        With more room at either side than any of its measurements needs.
        """
        height, width = shape[:2]
        room = ROOM_WIDTHS * self.width_px + ROOM_PX
        (u, v), (du, dv) = self.centre, self.direction
        if abs(dv) > abs(du):
            ends = u + (np.array([0, height - 1]) - v) * du / dv
            room *= float(np.hypot(1, du / dv))
            return slice(0, height), _within(ends, room, width)
        ends = v + (np.array([0, width - 1]) - u) * dv / du
        room *= float(np.hypot(1, dv / du))
        return _within(ends, room, height), slice(0, width)


def _within(ends: Array, room: float, size: int) -> slice:
    low, high = int(ends.min() - room), int(ends.max() + room) + 2
    return slice(min(max(low, 0), size), max(min(high, size), 0))


def find_bands(gray: Gray, widths_px: tuple[float, float], reduce: int | None = None) -> list[Band]:
    """Find bands in a gray image, the most promising first.

    Parameters
    ----------
    gray
        (H, W) uint8.
    widths_px
        Least and largest width.
    reduce
        Factor by which the image is reduced first; by default what makes it `LARGE_PX` long.
    """
    if reduce is None:
        reduce = max(1, -(-max(gray.shape) // LARGE_PX))
    segments = _segments(_reduced(gray, reduce))
    ends = (segments.reshape(-1, 2, 2) + 0.5) * reduce - 0.5
    contrast = _contrast(gray, ends, max(2.0, 1.5 * reduce))
    return _joined(_pairs(ends, contrast, widths_px))


def _reduced(gray: Gray, factor: int) -> Gray:
    """Average squares of so many pixels a side; what is left at the right and below is dropped."""
    height, width = (size // factor for size in gray.shape)
    if factor == 1 or min(height, width) == 0:
        return gray if factor == 1 else gray[:0]
    # Whole squares: else it takes five times as long.
    whole = gray[: height * factor, : width * factor]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def _segments(gray: Gray) -> Array:
    """Give line segments (n, 4), the longest first."""
    if min(gray.shape) < 8:
        return np.zeros((0, 4))
    found: object = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(gray)[0]
    if not isinstance(found, np.ndarray):  # OpenCV gives None for none
        return np.zeros((0, 4))
    lines = np.asarray(found, np.float64).reshape(-1, 4)
    length = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    return np.asarray(lines[np.argsort(-length, kind="stable")[:MOST_SEGMENTS]])


def _contrast(gray: Gray, ends: Array, off_px: float) -> Array:
    """Give how much brighter (n,) it is on the right-hand side of each segment, DN."""
    along = ends[:, 1] - ends[:, 0]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    share = np.linspace(0.05, 0.95, 15)
    points = ends[:, :1] + share[None, :, None] * along[:, None]
    sides = [_at(gray, points + sign * off_px * normal[:, None]) for sign in (1, -1)]
    return np.asarray(np.median(sides[0] - sides[1], axis=1))


def _at(gray: Gray, points: Array) -> Array:
    """Give the nearest pixel's value at points (..., 2)."""
    u = np.clip(np.rint(points[..., 0]), 0, gray.shape[1] - 1).astype(np.intp)
    v = np.clip(np.rint(points[..., 1]), 0, gray.shape[0] - 1).astype(np.intp)
    return gray[v, u].astype(np.float64)


def _pairs(ends: Array, contrast: Array, widths_px: tuple[float, float]) -> list[Band]:
    """Pair edges whose brighter sides look away from each other."""
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    keep = (length > 0) & (np.abs(contrast) >= 3)
    ends, along, length, contrast = ends[keep], along[keep], length[keep], contrast[keep]
    # Every edge directed so that the brighter side is on its right.
    ends = np.where((contrast < 0)[:, None, None], ends[:, ::-1], ends)
    direction = np.where((contrast < 0)[:, None], -along, along) / length[:, None]
    normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    middle = ends.mean(axis=1)
    bands = []
    cosine = direction @ direction.T
    i, j = np.nonzero(np.triu(cosine < -np.cos(PARALLEL_RAD)))
    for a, b in zip(i, j, strict=True):
        band = _pair(ends, direction, normal, middle, np.abs(contrast), int(a), int(b), widths_px)
        if band is not None:
            bands.append(band)
    return bands


def _pair(
    ends: Array,
    direction: Array,
    normal: Array,
    middle: Array,
    contrast: Array,
    a: int,
    b: int,
    widths_px: tuple[float, float],
) -> Band | None:
    axis = direction[a] - direction[b]
    axis /= np.linalg.norm(axis)
    t_a, t_b = np.sort((ends[a] - middle[a]) @ axis), np.sort((ends[b] - middle[a]) @ axis)
    low, high = max(t_a[0], t_b[0]), min(t_a[1], t_b[1])
    # At the middle of where they overlap; the other edge lies on the darker, the left side.
    t = (low + high) / 2
    at_a = middle[a] + direction[a] * (t / (direction[a] @ axis))
    at_b = middle[b] + direction[b] * ((t - (middle[b] - middle[a]) @ axis) / (direction[b] @ axis))
    width = float((at_a - at_b) @ normal[a])
    if not (widths_px[0] <= width <= widths_px[1] and high - low >= LEAST_OVERLAP * width):
        return None
    strength = min(contrast[a], contrast[b])
    return Band((at_a + at_b) / 2, axis, width, float(high - low), float((high - low) * strength))


def _joined(bands: list[Band]) -> list[Band]:
    """Join bands on one line and of about one width; the best first."""
    bands = sorted(bands, key=lambda band: -band.score)
    joined: list[Band] = []
    taken: NDArray[np.bool_] = np.zeros(len(bands), np.bool_)
    for k, best in enumerate(bands):
        if taken[k]:
            continue
        same = [j for j, other in enumerate(bands) if not taken[j] and _on_one_line(best, other)]
        taken[same] = True
        length = sum(bands[j].length_px for j in same)
        score = sum(bands[j].score for j in same)
        joined.append(Band(best.centre, best.direction, best.width_px, length, score))
    return sorted(joined, key=lambda band: -band.score)


def _on_one_line(band: Band, other: Band) -> bool:
    off = other.centre - band.centre
    across = abs(band.direction[0] * off[1] - band.direction[1] * off[0])
    tilt = abs(band.direction[0] * other.direction[1] - band.direction[1] * other.direction[0])
    reach = np.linalg.norm(off)
    return bool(
        tilt < PARALLEL_RAD
        and across < 0.3 * band.width_px + 0.01 * reach
        and 0.5 < other.width_px / band.width_px < 1.6
    )
