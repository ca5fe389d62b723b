"""A needle's first look: which end is its tip, and a shaft and a tip good to a pixel."""

from __future__ import annotations

import numpy as np

from simtip.detect.gray import Gray
from simtip.detect.observation import TipStatus
from simtip.detect.subpixel.bands import Band
from simtip.detect.subpixel.frame import Frame
from simtip.detect.subpixel.lit_side import with_lit_side
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.start import wedge_start
from simtip.detect.subpixel.trace import Trace, trace
from simtip.geometry import Array

RIM_PX, FACET_GAP, MOST_FACET = 2.0, 4, 0.4
"""Beside a needle's edges, what of a row is not looked at for a facet; rows that may interrupt it;
and how early it may begin, of the rows."""

FACET_BRIGHTER, FACET_SHARE = 0.1, 0.25
"""Than the background, of the needle's contrast; and the part of a row that is so bright."""

LEAST_ROWS = 28
"""Of shaft, to fit it."""

MOST_FARTHER = 2.0
"""Widths by which a needle may go on beyond the dark band beside its lit side."""

STRAYED_PX = 1.0
"""A shaft fitted so far from where it was traced is traced anew."""


def hanging(gray: Gray, band: Band) -> tuple[Frame, Trace]:
    """Turn the picture so that the band hangs tip down: the end within the picture is the tip."""
    found = []
    for direction in (band.direction, -band.direction):
        frame = Frame.down(direction, gray.shape)
        centre, along = frame.points(band.centre), frame.vectors(direction)
        slope = along[0] / along[1]
        line = (float(centre[0] - slope * centre[1]), float(slope))
        traced = trace(frame.view(gray), line, band.width_px * float(np.hypot(1, slope)))
        if traced is not None:
            found.append((frame, _with_lit_side(frame.view(gray), traced)))
    inside = [(frame, traced) for frame, traced in found if not traced.at_bottom]
    if not found:
        raise NoNeedleError(TipStatus.NOT_FOUND, "no band of one width goes on long enough")
    if not inside:
        raise NoNeedleError(
            TipStatus.TOUCHES_BORDER, "the needle leaves the picture at both ends: no tip in it"
        )
    if len(inside) == 1 or inside[0][1].at_top:
        return inside[0]
    # Both ends are in the picture: the sharper one is the tip.
    lengths = []
    for _, traced in inside:
        _, wedge = first_wedge(traced, first_shaft(traced))
        lengths.append(wedge[1] + wedge[2])
    return inside[int(np.argmax(lengths))]


def _with_lit_side(gray: Gray, traced: Trace) -> Trace:
    """Trace a band with a strip beside it that mirrors a lamp, if there is one."""
    whole = with_lit_side(gray, traced)
    wide = None if whole is None else trace(gray, *whole)
    if wide is None:
        return traced
    on = wide.rows[-1] - traced.rows[-1] > MOST_FARTHER * traced.width_px
    leaves = wide.at_bottom and not traced.at_bottom
    return traced if on or leaves else wide


def traced_anew(gray: Gray, shaft: Shaft, begun: Shaft) -> Trace | None:
    """Trace a shaft that turned out to lie elsewhere, or to be wider: where one side shines."""
    v = np.array(shaft.origin)
    half, slope = float(shaft.half_px(v)), float(shaft.slope(v))
    u = float(shaft.axis_u(v))
    if max(abs(u - begun.axis_u(v)), abs(half - begun.half_px(v))) < STRAYED_PX:
        return None
    return trace(gray, (u - slope * shaft.origin, slope), 2 * half * float(np.hypot(1, slope)))


def first_shaft(traced: Trace) -> Shaft:
    """Give a straight shaft through the middles of the edges, those that stray left out."""
    v = traced.rows.astype(np.float64)
    middle, width = (traced.left + traced.right) / 2, traced.right - traced.left
    usual = float(np.nanmedian(width)) if np.isfinite(width).any() else 0.0
    with np.errstate(invalid="ignore"):
        good = np.isfinite(middle) & (np.abs(width - usual) < 0.15 * usual + 1)
    if good.sum() < LEAST_ROWS:
        raise NoNeedleError(
            TipStatus.NOT_FOUND, f"only {int(good.sum())} rows have the needle's usual width"
        )
    origin, scale = float(v[-1]), float(len(v))
    t = (v - origin) / scale
    for _ in range(3):
        line = np.polyfit(t[good], middle[good], 1)
        off = np.abs(middle - np.polyval(line, t))
        with np.errstate(invalid="ignore"):
            kept = good & (off < 2.5 * max(float(np.median(off[good])), 0.3))
        if kept.sum() >= LEAST_ROWS:
            good = kept
    usual = float(np.median(width[good]))
    slope = float(line[0]) / scale
    return Shaft(
        origin,
        scale,
        np.array([line[1], line[0], 0.0, 0.0]),
        np.array([usual / 2 / np.hypot(1, slope), 0.0, 0.0]),
        np.full(2, 0.3),
        np.array([1.0, 0.005]),
        np.zeros((0, 0)),
        np.inf,
    )


def first_wedge(traced: Trace, shaft: Shaft) -> tuple[float, Array]:
    """Give the last row that shows the needle, and a wedge's shape, see `wedge_start`."""
    v = traced.rows.astype(np.float64)
    incline = float(np.hypot(1, shaft.slope(v[-1])))
    return wedge_start(
        traced.rows, traced.left, traced.right, shaft.axis_u(v), shaft.half_px(v), incline
    )


def shaft_end(gray: Gray, traced: Trace, shaft: Shaft, end: float) -> float:
    """Give the row before which the shaft ends: `end`, or where a bright facet begins before that.

    A facet that mirrors a lamp has edges as far apart as the shaft's, but is brighter than the
    background. What shines all along is no facet.
    """
    v = traced.rows.astype(np.float64)
    half = float(shaft.half_px(np.array(end)))
    reach = max(int(half - RIM_PX), 1)
    columns = np.rint(shaft.axis_u(v)).astype(np.intp)[:, None] + np.arange(-reach, reach + 1)
    seen = gray[traced.rows[:, None], np.clip(columns, 0, gray.shape[1] - 1)]
    bright = seen > traced.level + FACET_BRIGHTER * traced.contrast
    (shining,) = np.nonzero(bright.mean(axis=1) > FACET_SHARE)
    if not len(shining):
        return end
    (breaks,) = np.nonzero(np.diff(shining) > FACET_GAP)
    first = int(shining[breaks[-1] + 1]) if len(breaks) else int(shining[0])
    if first < len(v) * MOST_FACET or v[shining[-1]] < v[-1] - 2 * half:
        return end
    return min(end, float(v[first]))
