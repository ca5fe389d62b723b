"""The steps of section 3.2 of Lin et al. (2020), one public function each.

Gray is `simtip.detect.gray.to_gray`; then median filter (Eq. 10), threshold (Eq. 11), removal of
small components, Canny edges, and the lowest edge pixel.
"""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from simtip.detect.components import Connectivity, components
from simtip.detect.gray import Gray
from simtip.detect.lin2020_parameters import DEFAULTS, Polarity, Ties
from simtip.detect.parameters import bad_value
from simtip.geometry import Array

NARROW_PX = 96
"""OpenCV's median is ten times slower on images narrower than this: tall ones are laid down."""


def median_filter(gray: Gray, window: int = DEFAULTS.median_window) -> Gray:
    """Replace each pixel by the median of the square window around it (Eq. 10).

    Beyond the image its border pixels are repeated.

    Parameters
    ----------
    gray
        (H, W) uint8.
    window
        Side, px, odd; 1 changes nothing.

    Raises
    ------
    InputError
        The window is even or below 1.
    """
    if window < 1 or window % 2 == 0:
        raise bad_value("median_window", f"{window} is not odd and positive", "give 3, 5, 7, ...")
    if gray.shape[1] < NARROW_PX < gray.shape[0]:
        return _bytes(cv2.medianBlur(np.ascontiguousarray(gray.T), window).T.copy())
    return _bytes(cv2.medianBlur(gray, window))


def binarise(gray: Gray, threshold: int = DEFAULTS.threshold) -> Gray:
    """Give 255 at or above the threshold and 0 below (Eq. 11). (H, W) uint8 in and out."""
    return np.where(gray >= threshold, np.uint8(255), np.uint8(0))


def remove_small_components(
    binary: Gray,
    min_area_px: int = DEFAULTS.min_area_px,
    connectivity: Connectivity = DEFAULTS.connectivity,
    polarity: Polarity = DEFAULTS.polarity,
) -> Gray:
    """Turn components of fewer than `min_area_px` pixels into their surroundings.

    Parameters
    ----------
    binary
        (H, W) uint8 of 0 (needle) and 255. Not changed.
    min_area_px
        A component of exactly this area stays.
    connectivity
        4 or 8.
    polarity
        ``dark``: small components of 0 become 255; ``bright``: small components of 255 become
        0; ``both``: the dark ones first, then the bright ones.
    """
    cleaned = binary
    if polarity in ("dark", "both"):
        cleaned = _without_small(cleaned, 0, min_area_px, connectivity)
    if polarity in ("bright", "both"):
        cleaned = _without_small(cleaned, 255, min_area_px, connectivity)
    return cleaned


def _without_small(binary: Gray, value: int, min_area_px: int, connectivity: Connectivity) -> Gray:
    labels, areas = components(binary, connectivity, value)
    # label 0, all other pixels, has the new value already
    small = (areas < min_area_px)[labels]
    return np.where(small, np.uint8(255 - value), binary)


def keep_largest_component(
    binary: Gray, connectivity: Connectivity = DEFAULTS.connectivity
) -> Gray:
    """Turn every dark component but the largest into 255; of equal ones the upper stays."""
    labels, areas = components(binary, connectivity)
    if len(areas) < 2:
        return binary.copy()
    largest = 1 + int(np.argmax(areas[1:]))
    return np.where(labels == largest, np.uint8(0), np.uint8(255))


def edges(
    binary: Gray,
    low: float = DEFAULTS.canny_low,
    high: float = DEFAULTS.canny_high,
    aperture: Literal[3, 5, 7] = DEFAULTS.canny_aperture,
    *,
    l2: bool = DEFAULTS.canny_l2,
) -> Gray:
    """Mark the edges of the two-level image with 255 by Canny's operator, in (H, W) uint8."""
    return _bytes(cv2.Canny(binary, low, high, apertureSize=aperture, L2gradient=l2))


def lowest_edge_pixel(edge: Gray, ties: Ties = DEFAULTS.ties) -> Array | None:
    """Find the edge pixel with the largest v.

    Parameters
    ----------
    edge
        (H, W), not 0 on edges.
    ties
        When several lie on that row: ``mean`` of their longest unbroken run (the left one of
        equally long runs; a mean across a gap would lie beside both objects), or the
        outermost to the ``left`` or ``right``.

    Returns
    -------
    Array or None
        (2,) u, v in px, or None if there is no edge.
    """
    rows = np.flatnonzero(edge.any(axis=1))
    if rows.size == 0:
        return None
    us = np.flatnonzero(edge[rows[-1]])
    runs = np.split(us, np.flatnonzero(np.diff(us) > 1) + 1)
    u = {"mean": max(runs, key=len).mean(), "left": us[0], "right": us[-1]}[ties]
    return np.array([u, rows[-1]], dtype=np.float64)


def _bytes(image: object) -> Gray:
    return np.asarray(image, dtype=np.uint8)
