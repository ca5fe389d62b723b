"""One view with its tips marked, and two views side by side."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.overlay.inset import plan_inset
from simtip.overlay.legend import draw_legend
from simtip.overlay.marks import Marks, Picture, draw_marks
from simtip.overlay.room import Room


def draw_view(
    image_rgb: NDArray[np.uint8] | NDArray[np.uint16],
    *,
    title: str,
    tip_true_px: ArrayLike | None = None,
    tip_detected_px: ArrayLike | None = None,
    epipolar_line: ArrayLike | None = None,
    axis_px: ArrayLike | None = None,
    axis_detected_px: ArrayLike | None = None,
    reason: str | None = None,
    white_dn: float | None = None,
) -> Picture:
    """Draw the tips of one view over its image, with an enlarged inset and a legend.

    What is None is left out. The inset and the legend go to corners where they hide neither tip
    nor, if it can be had, the needle. In an image too small for them the inset is left out, and of
    the legend first the key, then the title, then the rest.

    Parameters
    ----------
    image_rgb
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16, DN.
    title
        First line of the legend. Characters outside ASCII become ``?``.
    tip_true_px, tip_detected_px
        (2,) u, v, px: a blue cross with an open centre; a vermilion ring with a dot.
    epipolar_line
        (3,) a, b, c of the line a u + b v + c = 0, px.
    axis_px
        (2,) direction from tip to hub in the image. With it the error, detected - true, is written
        along the axis (positive towards the hub) and across it (positive along (-axis_v, axis_u),
        the axis turned 90 degrees clockwise as seen); without it only its length.
    axis_detected_px
        (2,) direction from the detected tip to the hub: a thin vermilion line from the ring on.
    reason
        Why there is no detection, or another remark.
    white_dn
        DN shown as white, e.g. 4095 for 12 bits in uint16; by default the largest of the type.

    Returns
    -------
    ndarray
        (H, W, 3) uint8, RGB, a new array.

    Raises
    ------
    ValueError
        The image is empty or of another shape or type, a number is not finite, the axis or the
        direction of the line is zero, or ``white_dn`` is not above zero.
    """
    clean = _as_rgb8(image_rgb, white_dn)
    marks = Marks(
        true=_numbers(tip_true_px, 2, "tip_true_px"),
        detected=_numbers(tip_detected_px, 2, "tip_detected_px"),
        line=_numbers(epipolar_line, 3, "epipolar_line", directed=True),
        axis=_numbers(axis_px, 2, "axis_px", directed=True),
        detected_axis=_numbers(axis_detected_px, 2, "axis_detected_px", directed=True),
    )
    # One px of a picture shown about 800 px wide.
    unit = max(0.35, min(clean.shape[1] / 800, clean.shape[0] / 450))
    view = clean.copy()
    room = Room(clean, marks, unit)
    inset = plan_inset(room, marks, clean.shape, unit)
    if inset is not None:
        inset.outline_source(view)
    # The cross is open, usually, as far as the outlined block reaches.
    stroke, halo = max(1.0, 1.7 * unit), max(0.5, 0.8 * unit)
    draw_marks(view, marks, reach=26 * unit, stroke=stroke, halo=halo)
    if inset is not None:
        inset.draw(view, clean, marks, unit)
    draw_legend(view, room, title, marks, inset, reason, unit)
    return view


def side_by_side(left: Picture, right: Picture) -> Picture:
    """Put two (H, W, 3) uint8 pictures beside each other, tops aligned, with a thin white gap.

    Heights and widths may differ; what the lower one lacks is white.
    """
    height = max(left.shape[0], right.shape[0])
    width = left.shape[1] + right.shape[1]
    gap = max(2, round(max(left.shape[1], right.shape[1]) / 200))
    both = np.full((height, width + gap, 3), 255, dtype=np.uint8)
    both[: left.shape[0], : left.shape[1]] = left
    both[: right.shape[0], left.shape[1] + gap :] = right
    return both


def _as_rgb8(image: NDArray[np.uint8] | NDArray[np.uint16], white_dn: float | None) -> Picture:
    """Give a new (H, W, 3) uint8 picture; ``white_dn`` becomes 255."""
    if image.dtype.name not in {"uint8", "uint16"}:
        raise ValueError(f"an image is uint8 or uint16, not {image.dtype!s}")
    if image.ndim not in {2, 3} or image.shape[2:] not in {(), (3,)} or image.size == 0:
        raise ValueError(f"an image is (H, W) or (H, W, 3) with pixels, not {image.shape}")
    most = np.iinfo(image.dtype).max
    white = float(most if white_dn is None else white_dn)
    if not (white > 0 and math.isfinite(white)):
        raise ValueError(f"white_dn must be above zero, not {white_dn}")
    shades = np.rint(np.clip(np.arange(most + 1) * (255 / white), 0, 255)).astype(np.uint8)
    shown: Picture = shades[image]
    return np.repeat(shown[:, :, None], 3, axis=2) if image.ndim == 2 else shown


def _numbers(
    values: ArrayLike | None, count: int, name: str, *, directed: bool = False
) -> Array | None:
    """Check what was given; if `directed`, scale it so that the first two have length 1."""
    if values is None:
        return None
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise ValueError(f"{name} must be {count} finite numbers, not {numbers.tolist()}")
    length = math.hypot(*numbers[:2]) if directed else 1.0
    if not length > 0:
        raise ValueError(f"{name} has no direction: its first two numbers are zero")
    return np.asarray(numbers / length)
