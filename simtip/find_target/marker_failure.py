"""Why a ChArUco board was not found: what is in the image instead."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.target import Charuco
from simtip.target.charuco import marker_dictionary

LEAST = 4
"""Corners that OpenCV has to find for an explanation to hold."""

CROWD_EXPLAINED = 400
"""Most squares in an image that is searched again and again for an explanation."""

OTHERS = (
    "DICT_4X4_1000",
    "DICT_5X5_1000",
    "DICT_6X6_1000",
    "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_36h11",
)
"""Sets of markers that are tried to explain a failure; the smaller ones are parts of them."""

LEAST_OUTLINE = 0.03
"""Of a marker, as part of the image's longer side: OpenCV's own limit."""


def why_not(target: Charuco, image: NDArray[np.uint8], markers: int) -> str:
    """Explain a failure by what else is in the image."""
    if squares(image) > CROWD_EXPLAINED:
        return f"no markers of {target} are in the image"
    flipped = np.ascontiguousarray(image[:, ::-1])
    if _corners(target, flipped) >= LEAST:
        return f"{target} is there, but in a mirror: the image is flipped"
    if _corners(target, image, legacy=True) >= LEAST:
        return (
            f"the board begins with a white square, as OpenCV drew it before 4.6, not as {target}"
        )
    return _stray(target, image, markers)


def _stray(target: Charuco, image: NDArray[np.uint8], markers: int) -> str:
    """Explain it by the markers that are in the image."""
    if markers >= 2:
        return f"{markers} markers of {target} are there, but not the corners between them"
    stray = _count(target.dictionary, image)
    if stray >= 2:
        return (
            f"{stray} markers of {target.dictionary} are there, but not in the places that they"
            f" have on {target}: another size of board?"
        )
    seen = {name: _count(name, image) for name in OTHERS}
    best = max(seen, key=lambda name: seen[name])
    if seen[best] > 3:
        return f"no markers of {target.dictionary} are there, but {seen[best]} of {best}"
    return f"no markers of {target.dictionary} are in the image"


def _corners(target: Charuco, image: NDArray[np.uint8], *, legacy: bool = False) -> int:
    """Count the corners that OpenCV finds."""
    board = cv2.aruco.CharucoBoard(
        (target.columns, target.rows),
        target.square_mm,
        target.marker_mm,
        marker_dictionary(target.dictionary),
    )
    board.setLegacyPattern(legacy)
    _, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(image)
    return 0 if ids is None else len(ids)


def _count(dictionary: str, image: NDArray[np.uint8]) -> int:
    _, ids, _ = cv2.aruco.ArucoDetector(marker_dictionary(dictionary)).detectMarkers(image)
    return 0 if ids is None else len(ids)


def squares(image: NDArray[np.uint8]) -> int:
    """Count outlines that may be markers, about as OpenCV's search for them does."""
    dark = cv2.adaptiveThreshold(
        image, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, 23, 7
    )
    outlines, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    least = LEAST_OUTLINE * max(image.shape)
    long = [outline for outline in outlines if len(outline) >= least]
    return sum(len(cv2.approxPolyDP(o, 0.03 * len(o), closed=True)) == 4 for o in long)
