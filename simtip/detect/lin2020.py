"""Needle tip extraction of Lin et al. (2020), section 3.2.

Gray, median filter (Eq. 10), threshold (Eq. 11), removal of small components, Canny edges, and
the lowest edge pixel. It stays close to the text. Where the text is silent, the choice made here
is a parameter of `Lin2020Parameters`, described there.

The paper counts v upwards from the lower left corner and calls the tip the "down corner"; here v
grows downwards, so the tip is the edge pixel with the largest v.

The steps are in `simtip.detect.lin2020_steps`. `detect` gives what they give on the whole image, to
the bit, but works only where something is dark; `every_step` works out each image in full.

Canny marks whole pixels, so the answer is on the pixel grid (on half pixels in u, with the mean of
tied pixels). On the two-level image of a slender needle it marks the last dark row, and the dark
area ends half a pixel further down than that row's centre. OpenCV's Canny breaks ties to the left:
where the needle ends in a single pixel, the edge is found on it or one pixel to its left.
"""

from __future__ import annotations

import numpy as np

from simtip.detect.binarised import binarised
from simtip.detect.components import components, needle_axis
from simtip.detect.gray import Gray, to_gray
from simtip.detect.lin2020_parameters import DEFAULTS, Lin2020Parameters
from simtip.detect.lin2020_steps import (
    binarise,
    edges,
    keep_largest_component,
    lowest_edge_pixel,
    median_filter,
    remove_small_components,
)
from simtip.detect.observation import Layers, TipObservation, TipStatus
from simtip.detect.patch import Patch
from simtip.detect.protocol import FunctionDetector, Image


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
    kept = every_step(image, p) if layers else {}
    binary = _dark_patch(image, p)
    cleaned = Patch(_cleaned(binary.pixels, p), binary.u, binary.v).shrunk(_margin_px(p))
    if no_needle := _why_no_needle(image, binary.pixels, cleaned.pixels, p):
        return TipObservation.failed(*no_needle, layers=kept)
    edge = _edges(cleaned.pixels, p)
    tip = lowest_edge_pixel(edge, p.ties)
    if tip is None:
        reason = f"Canny with {p.canny_low:g} / {p.canny_high:g} finds no edge"
        return TipObservation.failed(TipStatus.NO_EDGE, reason, layers=kept)
    if cut := _why_cut_off(Patch(edge, cleaned.u, cleaned.v), image, p.border_margin_px):
        return TipObservation.failed(TipStatus.TOUCHES_BORDER, cut, layers=kept)
    axis = needle_axis(cleaned.pixels, tip, p.connectivity)
    return TipObservation.found(cleaned.outside(tip), axis_px=axis, layers=kept)


def every_step(image: Image, parameters: Lin2020Parameters = DEFAULTS) -> Layers:
    """Give what each step makes of the whole image: Fig. 7b to 7f by name, (H, W) uint8 each."""
    p = parameters
    gray = to_gray(image, p.weights, p.full_scale)
    filtered = median_filter(gray, p.median_window)
    binary = binarise(filtered, p.threshold)
    cleaned = _cleaned(binary, p)
    names = ("gray", "filtered", "binary", "cleaned", "edges")
    steps = (gray, filtered, binary, cleaned, _edges(cleaned, p))
    return dict(zip(names, steps, strict=True))


def _dark_patch(image: Image, p: Lin2020Parameters) -> Patch:
    """Give the part of the thresholded image that has dark pixels, as if threshold came last.

    The median of an odd number of values is below the threshold where most of them are: filter
    and threshold may change places. A pixel outside the rectangle around all dark pixels has
    fewer than half of its window inside, and so stays bright.
    """
    dark = Patch(binarised(image, p.threshold, p.weights, p.full_scale))
    if p.polarity == "dark":
        dark = dark.shrunk(_margin_px(p))
    filtered = Patch(median_filter(dark.pixels, p.median_window), dark.u, dark.v)
    # whether a bright component is small depends on all of the image
    return filtered.shrunk(_margin_px(p)) if p.polarity == "dark" else filtered


def _margin_px(p: Lin2020Parameters) -> int:
    """Give how far from a dark pixel Canny may look: half its window and two pixels more."""
    return p.canny_aperture // 2 + 2


def _cleaned(binary: Gray, p: Lin2020Parameters) -> Gray:
    cleaned = remove_small_components(binary, p.min_area_px, p.connectivity, p.polarity)
    return keep_largest_component(cleaned, p.connectivity) if p.keep == "largest" else cleaned


def _edges(cleaned: Gray, p: Lin2020Parameters) -> Gray:
    return edges(cleaned, p.canny_low, p.canny_high, p.canny_aperture, l2=p.canny_l2)


def _why_no_needle(
    image: Image, binary: Gray, cleaned: Gray, p: Lin2020Parameters
) -> tuple[TipStatus, str] | None:
    """Say why there is no needle in the two-level image, if so."""
    if binary.all():
        darkest = _filtered(image, p).min()
        reason = f"no pixel is darker than T = {p.threshold} (darkest is {darkest})"
        return TipStatus.NOTHING_DARKER_THAN_THRESHOLD, reason
    if not binary.any():
        brightest = _filtered(image, p).max()
        reason = f"every pixel is darker than T = {p.threshold} (brightest is {brightest})"
        return TipStatus.EVERYTHING_DARKER_THAN_THRESHOLD, reason
    if cleaned.all():
        areas = components(binary, p.connectivity)[1][1:]
        of_how_many = f"the largest of {len(areas)} has {areas.max()} px"
        reason = f"no dark component has {p.min_area_px} px or more ({of_how_many})"
        return TipStatus.NO_COMPONENT_LARGE_ENOUGH, reason
    return None


def _filtered(image: Image, p: Lin2020Parameters) -> Gray:
    return median_filter(to_gray(image, p.weights, p.full_scale), p.median_window)


def _why_cut_off(edge: Patch, image: Image, margin_px: int) -> str | None:
    """Say why the lower end may be cut off by the border, if so; there has to be an edge.

    A needle enters through a border, so only its lower end has to be clear of all four. Every
    edge pixel of the lowest row counts.
    """
    row = int(np.flatnonzero(edge.pixels.any(axis=1))[-1])
    us = edge.u + np.flatnonzero(edge.pixels[row])
    v = edge.v + row
    height, width = image.shape[:2]
    room = min(v, height - 1 - v, int(us.min()), width - 1 - int(us.max()))
    if room >= margin_px:
        return None
    where = f"v = {v}, u = {us.min()} to {us.max()}"
    return (
        f"the lowest edge, at {where}, is {room} px from the border of the {width} x {height} "
        f"image; a tip needs {margin_px} px"
    )


DETECTOR = FunctionDetector(
    name="lin2020",
    summary="Lin et al. (2020), section 3.2: threshold, small components, Canny, lowest pixel",
    parameters_type=Lin2020Parameters,
    function=detect,
)
