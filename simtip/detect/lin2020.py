"""Needle tip extraction of Lin et al. (2020), section 3.2, one public function a step.

Gray, median filter (Eq. 10), threshold (Eq. 11), removal of small components, Canny edges, and
the lowest edge pixel. It stays close to the text. Where the text is silent, the choice made here
is a parameter of `Lin2020Parameters`, described there.

The paper counts v upwards from the lower left corner and calls the tip the "down corner"; here v
grows downwards, so the tip is the edge pixel with the largest v.

Canny marks whole pixels, so the answer is on the pixel grid (on half pixels in u, with the mean of
tied pixels). On the two-level image of a slender needle it marks the last dark row, and the dark
area ends half a pixel further down than that row's centre. OpenCV's Canny breaks ties to the left:
where the needle ends in a single pixel, the edge is found on it or one pixel to its left.
"""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from simtip.detect.components import Connectivity, components, needle_axis
from simtip.detect.gray import Gray, to_gray
from simtip.detect.lin2020_parameters import Lin2020Parameters, Polarity, Ties
from simtip.detect.observation import Layers, TipObservation, TipStatus
from simtip.detect.parameters import bad_value
from simtip.detect.protocol import FunctionDetector, Image
from simtip.geometry import Array

DEFAULTS = Lin2020Parameters()


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


def detect(
    image: Image, parameters: Lin2020Parameters = DEFAULTS, *, layers: bool = False
) -> TipObservation:
    """Extract the needle tip as section 3.2 and Fig. 6 of Lin et al. (2020) describe.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16. Not changed.
    parameters
        All steps' parameters.
    layers
        Keep the intermediate images: ``gray``, ``filtered``, ``binary``, ``cleaned``,
        ``edges``, each (H, W) uint8.

    Returns
    -------
    TipObservation
        The tip and the axis, or the reason why there is none. No covariance: the error of this
        method is mostly systematic, and it has no model of it.

    Raises
    ------
    InputError
        The array is no image of a supported kind (see `to_gray`).
    """
    p = parameters
    gray = to_gray(image, p.weights, p.full_scale)  # Fig. 7b
    filtered = median_filter(gray, p.median_window)  # Fig. 7c
    binary = binarise(filtered, p.threshold)  # Fig. 7d
    cleaned = remove_small_components(binary, p.min_area_px, p.connectivity, p.polarity)  # Fig. 7e
    if p.keep == "largest":
        cleaned = keep_largest_component(cleaned, p.connectivity)
    edge = edges(cleaned, p.canny_low, p.canny_high, p.canny_aperture, l2=p.canny_l2)  # Fig. 7f
    names = ("gray", "filtered", "binary", "cleaned", "edges")
    steps = (gray, filtered, binary, cleaned, edge)
    kept: Layers = dict(zip(names, steps, strict=True)) if layers else {}
    if no_needle := _why_no_needle(filtered, binary, cleaned, p):
        return TipObservation.failed(*no_needle, layers=kept)
    tip = lowest_edge_pixel(edge, p.ties)
    if tip is None:
        reason = f"Canny with {p.canny_low:g} / {p.canny_high:g} finds no edge"
        return TipObservation.failed(TipStatus.NO_EDGE, reason, layers=kept)
    if cut := _why_cut_off(edge, p.border_margin_px):
        return TipObservation.failed(TipStatus.TOUCHES_BORDER, cut, layers=kept)
    axis = needle_axis(cleaned, tip, p.connectivity)
    return TipObservation.found(tip, axis_px=axis, layers=kept)


def _why_no_needle(
    filtered: Gray, binary: Gray, cleaned: Gray, p: Lin2020Parameters
) -> tuple[TipStatus, str] | None:
    """Say why there is no needle in the two-level image, if so."""
    if binary.all():
        reason = f"no pixel is darker than T = {p.threshold} (darkest is {filtered.min()})"
        return TipStatus.NOTHING_DARKER_THAN_THRESHOLD, reason
    if not binary.any():
        reason = f"every pixel is darker than T = {p.threshold} (brightest is {filtered.max()})"
        return TipStatus.EVERYTHING_DARKER_THAN_THRESHOLD, reason
    if cleaned.all():
        areas = components(binary, p.connectivity)[1][1:]
        of_how_many = f"the largest of {len(areas)} has {areas.max()} px"
        reason = f"no dark component has {p.min_area_px} px or more ({of_how_many})"
        return TipStatus.NO_COMPONENT_LARGE_ENOUGH, reason
    return None


def _why_cut_off(edge: Gray, margin_px: int) -> str | None:
    """Say why the lower end may be cut off by the border, if so; there has to be an edge.

    A needle enters through a border, so only its lower end has to be clear of all four. Every
    edge pixel of the lowest row counts.
    """
    rows, columns = np.nonzero(edge)
    v = int(rows.max())
    us = columns[rows == v]
    height, width = edge.shape
    room = min(v, height - 1 - v, int(us.min()), width - 1 - int(us.max()))
    if room >= margin_px:
        return None
    where = f"v = {v}, u = {us.min()} to {us.max()}"
    return (
        f"the lowest edge, at {where}, is {room} px from the border of the {width} x {height} "
        f"image; a tip needs {margin_px} px"
    )


def _bytes(image: object) -> Gray:
    return np.asarray(image, dtype=np.uint8)


DETECTOR = FunctionDetector(
    name="lin2020",
    summary="Lin et al. (2020), section 3.2: threshold, small components, Canny, lowest pixel",
    parameters_type=Lin2020Parameters,
    function=detect,
)
