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

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.detect.observation import Layers, TipObservation, TipStatus
from simtip.detect.parameters import Declared, DetectorParameters, bad_value
from simtip.detect.protocol import FunctionDetector, Image
from simtip.errors import InputError
from simtip.geometry import Array

Gray: TypeAlias = NDArray[np.uint8]
Connectivity: TypeAlias = Literal[4, 8]
Polarity: TypeAlias = Literal["dark", "bright", "both"]
Ties: TypeAlias = Literal["mean", "left", "right"]

LUMA_WEIGHTS = (0.299, 0.587, 0.114)
"""R, G, B weights of ITU-R BT.601, the usual "weighted average"."""

MIN_ELONGATION = 2.0
"""A component less elongated than this (ratio of standard deviations) has no axis to speak of."""


@dataclass(frozen=True)
class Lin2020Parameters(DetectorParameters):
    """Parameters of `detect`. The defaults are the paper's where it gives a number."""

    weights: Annotated[
        tuple[float, float, float],
        Declared(
            "R, G, B weights of the gray value, summing to 1 (paper: 'weighted average')",
            minimum=0,
            maximum=1,
        ),
    ] = LUMA_WEIGHTS
    full_scale: Annotated[
        int | None,
        Declared(
            "white of a 16-bit image, DN, e.g. 4095 for 12-bit data; none is 65535",
            minimum=1,
            maximum=65535,
        ),
    ] = None
    median_window: Annotated[
        int,
        Declared(
            "side of the square median window, px, odd; 1 is no filter (paper: silent)",
            minimum=1,
            maximum=255,
        ),
    ] = 5
    threshold: Annotated[
        int,
        Declared(
            "T, 8-bit DN: below it is needle, at it or above is background", minimum=1, maximum=255
        ),
    ] = 105
    min_area_px: Annotated[
        int, Declared("components of fewer pixels are removed, px", minimum=0, maximum=2**30)
    ] = 4500
    connectivity: Annotated[
        Connectivity, Declared("4 or 8 neighbours make a component (paper: silent)")
    ] = 8
    polarity: Annotated[
        Polarity,
        Declared(
            "which small components are removed: dark ones (needle polarity), bright ones (glare "
            "inside the needle), or dark ones and then bright ones (paper: silent)"
        ),
    ] = "dark"
    keep: Annotated[
        Literal["all", "largest"],
        Declared("dark components that stay: all large enough (the text), or only the largest"),
    ] = "all"
    canny_low: Annotated[float, Declared("lower threshold of Canny", minimum=0, maximum=1e6)] = 40.0
    canny_high: Annotated[float, Declared("upper threshold of Canny", minimum=0, maximum=1e6)] = (
        80.0
    )
    canny_aperture: Annotated[
        Literal[3, 5, 7], Declared("side of Canny's Sobel window, px (paper: silent)")
    ] = 3
    canny_l2: Annotated[
        bool,
        Declared("gradient length by the L2 norm, not by |gx| + |gy| (paper: silent)"),
    ] = False
    ties: Annotated[
        Ties,
        Declared(
            "which of several edge pixels on the lowest row is the tip: the mean of their longest "
            "unbroken run, the left one or the right one (paper: silent)"
        ),
    ] = "mean"
    border_margin_px: Annotated[
        int,
        Declared(
            "a tip closer than this to the border is refused, px; 0 refuses none",
            minimum=0,
            maximum=2**30,
        ),
    ] = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        if abs(sum(self.weights) - 1) > 1e-6:
            raise bad_value("weights", f"they sum to {sum(self.weights):g}", "make the sum 1")
        if self.median_window % 2 == 0:
            raise bad_value("median_window", f"{self.median_window} is even", "give an odd number")
        if self.canny_low > self.canny_high:
            raise bad_value(
                "canny_low",
                f"{self.canny_low:g} is above canny_high = {self.canny_high:g}",
                "give the lower threshold here",
            )


DEFAULTS = Lin2020Parameters()


def to_gray(
    image: Image,
    weights: tuple[float, float, float] = LUMA_WEIGHTS,
    full_scale: int | None = None,
) -> Gray:
    """Convert to 8-bit gray by a weighted average, rounded once, halves up.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16, of any memory layout. Not changed.
    weights
        Of R, G and B, summing to 1. Not used on a gray image.
    full_scale
        For uint16 only: the value that becomes 255, e.g. 1023 or 4095 for 10- or 12-bit data.
        None is 65535, which divides by 257.

    Returns
    -------
    NDArray[np.uint8]
        (H, W), contiguous.

    Raises
    ------
    InputError
        Another shape or type, no pixel at all, a `full_scale` with an 8-bit image, or a pixel
        above `full_scale`.
    """
    _check_image(image, full_scale)
    white = 255 if image.dtype == np.uint8 else full_scale or 65535
    if image.ndim == 2 and image.dtype == np.uint8:
        return np.array(image, dtype=np.uint8, order="C")
    value = image.astype(np.float64)
    if image.ndim == 3:
        value = value[..., 0] * weights[0] + value[..., 1] * weights[1] + value[..., 2] * weights[2]
    # The 1e-9 keeps exact halves, which the weights cannot represent, on the upper side.
    gray = np.floor(value * (255 / white) + (0.5 + 1e-9)).astype(np.uint8)
    return np.ascontiguousarray(gray)


def _check_image(image: Image, full_scale: int | None) -> None:
    if not isinstance(image, np.ndarray) or image.dtype not in (np.uint8, np.uint16):
        kind = image.dtype if isinstance(image, np.ndarray) else type(image).__name__
        raise InputError(f"the image is {kind}", remedy="give an array of uint8 or uint16")
    if image.size == 0 or not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)):
        shape = " x ".join(map(str, image.shape))
        raise InputError(
            f"the image has the shape {shape or 'of a number'}",
            remedy="give (H, W) gray or (H, W, 3) RGB with at least one pixel",
        )
    if full_scale is None:
        return
    if image.dtype == np.uint8:
        raise bad_value("full_scale", "the image has 8 bits", "leave full_scale out")
    if (brightest := int(image.max())) > full_scale:
        raise bad_value(
            "full_scale",
            f"a pixel of {brightest} is above {full_scale}",
            "give the white level of the camera's bit depth",
        )


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


def components(
    binary: Gray, connectivity: Connectivity = DEFAULTS.connectivity, value: int = 0
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Label the connected components of the pixels that equal `value`.

    Returns
    -------
    labels
        (H, W), 0 for all other pixels, then 1, 2, ...
    areas
        Pixels with each label, at the label's index.
    """
    mask = (binary == value).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=connectivity)
    areas = np.asarray(stats[:count, cv2.CC_STAT_AREA], dtype=np.int64)
    return np.asarray(labels, dtype=np.int32), areas


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


def needle_axis(
    binary: Gray, tip_px: Array, connectivity: Connectivity = DEFAULTS.connectivity
) -> Array | None:
    """Estimate the needle's direction as the principal axis of the component at the tip.

    Every pixel of the component counts alike, so the direction hardly depends on the tip's
    shape. The paper has no such step; it serves pictures and checks, not the tip's position.

    Parameters
    ----------
    binary
        (H, W) uint8, needle 0.
    tip_px
        (2,) u, v.
    connectivity
        4 or 8.

    Returns
    -------
    Array or None
        (2,) unit direction from the tip towards the component's centroid, or None if no
        component is within 1 px of the tip or it is less elongated than `MIN_ELONGATION`.
    """
    labels, _ = components(binary, connectivity)
    # An edge pixel lies on the needle or next to it.
    u, v = (int(c) for c in np.floor(tip_px + 0.5))
    near = labels[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
    if not near.any():
        return None
    label = int(np.bincount(near[near > 0]).argmax())
    vs, us = np.nonzero(labels == label)
    pixels = np.stack([us, vs], axis=1).astype(np.float64)
    centroid = pixels.mean(axis=0)
    centred = pixels - centroid
    variances, directions = np.linalg.eigh(centred.T @ centred / len(pixels))
    # 1/12: a pixel is a square, so a line one pixel wide is no line of width 0
    if variances[1] + 1 / 12 < MIN_ELONGATION**2 * (variances[0] + 1 / 12):
        return None
    axis: Array = directions[:, 1]
    return axis if axis @ (centroid - tip_px) >= 0 else -axis


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
    gray = to_gray(image, p.weights, p.full_scale)
    filtered = median_filter(gray, p.median_window)
    binary = binarise(filtered, p.threshold)
    cleaned = remove_small_components(binary, p.min_area_px, p.connectivity, p.polarity)
    if p.keep == "largest":
        cleaned = keep_largest_component(cleaned, p.connectivity)
    edge = edges(cleaned, p.canny_low, p.canny_high, p.canny_aperture, l2=p.canny_l2)
    kept: Layers = {}
    if layers:
        kept = {
            "gray": gray,
            "filtered": filtered,
            "binary": binary,
            "cleaned": cleaned,
            "edges": edge,
        }
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
