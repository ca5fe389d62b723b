"""What a picture of a known needle is made of: brightness that is linear in unknown amplitudes.

The background is a parabola over the window. On the shaft and on a curved tip the brightness is a
smooth function of the place across, which changes along the needle; right at the edges it is the
same on both, for there rough metal mirrors what is behind the needle. A facet is lit evenly, but
for a slope.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.subpixel.picture import Window
from simtip.geometry import Array
from simtip.refine.brightness import MODES, TIP_MODES, tables, tip_tables
from simtip.refine.drawing import Drawing
from simtip.refine.outline import at_z

GROUND = 6
RIM_LEVEL, RIM_DEVIATION = 0.48, 0.1
"""Brightness at the edges, of the background's."""

RIM_TIE = 0.01
"""Difference of that between shaft and tip; see the module."""

RIM_CHANGE = 0.02
"""Of it along the needle, over the window."""

USUAL, CHANGE = 0.3, 0.15
"""Deviation of the other modes, of the background's brightness, and of their change along."""

FACET_SLOPE = 0.1


@dataclass(frozen=True, eq=False)
class Layout:
    """Which column is what.

    Attributes
    ----------
    nose
        There is a curved tip.
    facets
        Which facets are seen.
    """

    nose: bool
    facets: tuple[int, ...]

    @property
    def size(self) -> int:
        """How many columns."""
        return GROUND + 2 * MODES + (2 * TIP_MODES if self.nose else 0) + 3 * len(self.facets)

    @property
    def nose_at(self) -> int:
        """First column of the tip."""
        return GROUND + 2 * MODES

    @property
    def facets_at(self) -> int:
        """First column of the facets."""
        return self.nose_at + (2 * TIP_MODES if self.nose else 0)


def layout_of(drawing: Drawing, *, curved: bool) -> Layout:
    """Tell what is seen."""
    return Layout(curved, tuple(k for k, f in enumerate(drawing.facets) if f is not None))


def ground(window: Window) -> Array:
    """Give the background's columns (GROUND, H, W)."""
    v, u = np.meshgrid(
        np.linspace(-1, 1, window.height), np.linspace(-1, 1, window.width), indexing="ij"
    )
    return np.stack([np.ones_like(u), u, v, u * u, u * v, v * v])


def window_points(window: Window) -> tuple[Array, Array]:
    """Give u and v (H, W) of a window's pixels."""
    v, u = np.meshgrid(
        np.arange(window.v, window.v + window.height, dtype=np.float64),
        np.arange(window.u, window.u + window.width, dtype=np.float64),
        indexing="ij",
    )
    return u, v


def along(drawing: Drawing, window: Window) -> tuple[Array, Array, Array]:
    """Give the places of pixels (H, W): along the shaft, along the tip, across in half widths."""
    x, z = drawing.outline.place(*window_points(window))
    depth = max(drawing.outline.depth_px, 1.0)
    low, high = (float(at_z(side, np.array(depth))) for side in drawing.outline.shaft)
    half = max((high - low) / 2, 1.0)
    return np.maximum(z - depth, 0) / window.height, z / depth - 0.5, x / half


def columns(drawing: Drawing, window: Window, layout: Layout) -> Array:
    """Give all columns (H W, n) at an outline."""
    cells = drawing.cells
    modes = tables()
    on_body = cells.pixels([drawing.mean(t) * drawing.round_part for t in modes])
    t, t_nose, across = along(drawing, window)
    open_part = 1 - cells.pixels([drawing.body])
    parts = [open_part * ground(window), on_body, on_body * t]
    if layout.nose:
        nose_part = drawing.round_part * drawing.nose
        on_nose = cells.pixels([drawing.mean(t) * nose_part for t in tip_tables()])
        parts += [on_nose, on_nose * t_nose]
    for k in layout.facets:
        facet = drawing.facets[k]
        seen = cells.pixels([np.zeros_like(drawing.body) if facet is None else facet])
        parts += [seen, seen * across, seen * t_nose]
    return np.concatenate(parts).reshape(layout.size, -1).T


def picture(drawing: Drawing, window: Window, layout: Layout, amplitude: Array) -> Array:
    """Give the picture (H W,) of an outline at given brightness (n,): columns times amplitudes."""
    cells, modes = drawing.cells, tables()
    t, t_nose, across = along(drawing, window)
    part = drawing.round_part
    steady, change = amplitude[GROUND : layout.nose_at].reshape(2, -1) @ modes
    stack = [drawing.body, drawing.mean(steady) * part, drawing.mean(change) * part]
    if layout.nose:
        nose_part = drawing.round_part * drawing.nose
        values = amplitude[layout.nose_at : layout.facets_at].reshape(2, -1) @ tip_tables()
        stack += [drawing.mean(value) * nose_part for value in values]
    empty = np.zeros_like(drawing.body)
    for k in layout.facets:
        facet = drawing.facets[k]
        stack.append(empty if facet is None else facet)
    seen = cells.pixels(stack)
    found = (1 - seen[0]) * np.tensordot(amplitude[:GROUND], ground(window), 1)
    found = found + seen[1] + seen[2] * t
    at = 3
    if layout.nose:
        found = found + seen[3] + seen[4] * t_nose
        at = 5
    for k in range(len(layout.facets)):
        a, b, c = amplitude[layout.facets_at + 3 * k : layout.facets_at + 3 * k + 3]
        found = found + seen[at + k] * (a + b * across + c * t_nose)
    return np.asarray(found.reshape(-1))


def prior(layout: Layout, level: float) -> tuple[Array, Array]:
    """Give precision and mean (n,) of the amplitudes.

    `level` is the background's usual gray value.
    """
    deviation, mean = np.full(layout.size, USUAL), np.zeros(layout.size)
    deviation[:GROUND] = [1e3, 1, 1, 1, 1, 1]
    rim, change, tip = GROUND, GROUND + MODES, layout.nose_at
    deviation[change : change + MODES] = CHANGE
    deviation[rim], deviation[change] = RIM_DEVIATION, RIM_CHANGE
    mean[rim] = RIM_LEVEL
    if layout.nose:
        deviation[tip + TIP_MODES : tip + 2 * TIP_MODES] = CHANGE
        deviation[tip], deviation[tip + TIP_MODES] = RIM_TIE, RIM_CHANGE
    for at in range(layout.facets_at, layout.size, 3):
        deviation[at : at + 3] = 2.0, FACET_SLOPE, FACET_SLOPE
    return 1 / (deviation * level) ** 2, mean * level
