"""Images in a page: the whole one small, what is around the tip pixel for pixel."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.page.parts import Layer, View

Picture = NDArray[np.uint8]
Point = tuple[float, float]

LEAST_PX = 84.0
"""Width of what is shown first."""

AROUND = 3.4
"""Likewise, in distances between the tips."""

ASPECT = 4 / 3

EXACT = 1.9
"""What is kept pixel for pixel, in sizes of what is shown first."""

MOST_EXACT_PX = 640


def tip_view(
    title: str,
    image: NDArray[Any],
    *,
    white_dn: float = 255,
    true: Point | None = None,
    detected: Point | None = None,
    axis: Point | None = None,
    line: tuple[float, float, float] | None = None,
    caption: str = "",
    overview_px: int = 1400,
) -> View:
    """Give a view of an image that begins at its tips.

    Parameters
    ----------
    title
        Which view.
    image
        (H, W) or (H, W, 3) RGB, DN.
    white_dn
        DN shown as white.
    true, detected, axis, line, caption
        See `View`.
    overview_px
        Longest side of the whole image in the page.
    """
    shown = as_8_bit(image, white_dn)
    height, width = shown.shape[:2]
    inside = [p for p in (true, detected) if p is not None and _inside(p, width, height)]
    focus = _focus(inside, width, height)
    layers = [overview(shown, overview_px)]
    exact = _exact(shown, focus) if inside else None
    if exact is not None:
        layers.append(exact)
    return View(title, width, height, layers, focus, true, detected, axis, line, caption)


def overview(shown: Picture, most_px: int, quality: int = 84) -> Layer:
    """Give a whole picture, made smaller if it is large, as JPEG."""
    height, width = shown.shape[:2]
    shrunk = most_px / max(height, width)
    small = shown
    if shrunk < 1:
        size = max(1, round(width * shrunk)), max(1, round(height * shrunk))
        small = np.asarray(cv2.resize(shown, size, interpolation=cv2.INTER_AREA), np.uint8)
    return Layer(
        _uri(small, ".jpg", [cv2.IMWRITE_JPEG_QUALITY, quality]), -0.5, -0.5, width, height
    )


def as_8_bit(image: NDArray[Any], white_dn: float) -> Picture:
    """Give an image as it is shown, (H, W) or (H, W, 3) uint8."""
    if image.dtype == np.uint8 and white_dn == 255:
        return np.asarray(image, np.uint8)
    return np.rint(np.clip(image * (255 / white_dn), 0, 255)).astype(np.uint8)


def _inside(point: Point, width: int, height: int) -> bool:
    return -0.5 <= point[0] < width - 0.5 and -0.5 <= point[1] < height - 0.5


def _focus(tips: Sequence[Point], width: int, height: int) -> tuple[float, float, float, float]:
    """Give the part of an image that holds all its tips with some room, (u, v, width, height)."""
    if not tips:
        return -0.5, -0.5, float(width), float(height)
    u, v = np.mean(tips, axis=0)
    apart = math.dist(tips[0], tips[-1])
    wide = min(max(LEAST_PX, AROUND * apart), float(width))
    high = min(wide / ASPECT, float(height))
    wide = min(wide, high * ASPECT)
    left = float(np.clip(u - wide / 2, -0.5, width - 0.5 - wide))
    top = float(np.clip(v - high / 2, -0.5, height - 0.5 - high))
    return left, top, wide, high


def _exact(shown: Picture, focus: tuple[float, float, float, float]) -> Layer | None:
    left, top, wide, high = focus
    grown = min(EXACT, MOST_EXACT_PX / wide)
    if grown < 1:
        return None
    more_u, more_v = (grown - 1) * wide / 2, (grown - 1) * high / 2
    height, width = shown.shape[:2]
    u0, v0 = max(0, math.floor(left - more_u)), max(0, math.floor(top - more_v))
    u1 = min(width, math.ceil(left + wide + more_u))
    v1 = min(height, math.ceil(top + high + more_v))
    crop = shown[v0:v1, u0:u1]
    return Layer(_uri(crop, ".png", []), u0 - 0.5, v0 - 0.5, u1 - u0, v1 - v0)


def _uri(picture: Picture, ending: str, options: list[int]) -> str:
    ordered = picture if picture.ndim == 2 else picture[:, :, ::-1]
    done, encoded = cv2.imencode(ending, np.ascontiguousarray(ordered), options)
    if not done:
        raise ValueError(f"OpenCV cannot write a picture of shape {picture.shape}")
    kind = "jpeg" if ending == ".jpg" else "png"
    return f"data:image/{kind};base64,{base64.b64encode(encoded.tobytes()).decode()}"
