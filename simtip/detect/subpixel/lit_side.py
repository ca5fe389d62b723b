"""A needle of which one side mirrors a lamp: the dark band beside the light is not all of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.detect.gray import Gray
from simtip.detect.subpixel.trace import Trace
from simtip.geometry import Array

BESIDE_WIDTHS, BESIDE_PX = 2.0, 8
"""How far beside a band is looked, in its widths, and px more."""

GROUND_SHARE = 0.3
"""Part of that, at its outer end, which tells the ground; the brighter side's counts."""

BRIGHTER, OFF = 0.25, 0.1
"""Than the ground, of the needle's contrast, a lit strip is; and what is still no ground."""

PROFILE_ROWS = 64
"""About so many rows tell the profile."""

GAP_PX, RIM_PX = 2, 4
"""From the band's edge to the strip, at most; and the needle's rim beyond the strip."""

MOST_STRIP = 1.5
"""Widths of the band that it may be wide."""


def with_lit_side(gray: Gray, traced: Trace) -> tuple[tuple[float, float], float] | None:
    """Give middle line and width along u of a band and a lit strip beside it; None without one.

    Parameters
    ----------
    gray
        (H, W) uint8, turned.
    traced
        The dark band.

    Returns
    -------
    line, width_px
        As `simtip.detect.subpixel.trace.trace` takes them.
    """
    half = traced.width_px / 2
    reach = int(np.ceil(half + BESIDE_WIDTHS * traced.width_px)) + BESIDE_PX
    profile = _profile(gray, traced, reach)
    sides = profile[reach::-1], profile[reach:]
    # One for both sides: beside something dark the ground would look lit.
    outer = int(GROUND_SHARE * len(sides[0]))
    ground = max(float(np.median(side[-outer:])) for side in sides)
    left, right = (_strip(side - ground, half, traced.contrast) for side in sides)
    if (left is None) == (right is None):
        return None
    low, high = -(left or half), right or half
    a, b = traced.centre
    return (a + (low + high) / 2, b), high - low


def _profile(gray: Gray, traced: Trace, reach: int) -> Array:
    """Give the median (2 reach + 1,) of some traced rows, by distance along u from the middle."""
    v = traced.rows[:: max(1, len(traced.rows) // PROFILE_ROWS)]
    middle = np.rint(traced.centre[0] + traced.centre[1] * v).astype(np.intp)
    columns = middle[:, None] + np.arange(-reach, reach + 1)
    seen = gray[v[:, None], np.clip(columns, 0, gray.shape[1] - 1)]
    return np.asarray(np.median(seen, axis=0), np.float64)


def _strip(off: Array, half: float, contrast: float) -> float | None:
    """Give how far from the middle a lit strip and its rim reach on one side, px.

    `off` (n,) is a profile less the ground, from the band's middle on.
    """
    begin = round(half)
    lit = np.flatnonzero(off[begin : begin + GAP_PX + 1] > BRIGHTER * contrast)
    if not len(lit):
        return None
    first = begin + int(lit[0])
    dark = np.flatnonzero(off[first:] <= BRIGHTER * contrast)
    if not len(dark) or dark[0] > MOST_STRIP * 2 * half:
        return None
    last = first + int(dark[0])
    rim: NDArray[np.intp] = np.flatnonzero(np.abs(off[last : last + RIM_PX + 1]) > OFF * contrast)
    return float(last + (rim[-1] if len(rim) else 0)) + 0.5
