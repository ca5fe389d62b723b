"""Where the shaft begins, behind a tip that has no facet: pixels there are left out.

A needle's brightness changes at the circle where its tip ends. Seen aslant that is an arc, whose
bend only a known camera tells. A straight line in its place would pull at the tip; its flanks are
enough to hold it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simtip.detect.subpixel.comparison import WITHIN
from simtip.detect.subpixel.scenery import Scenery
from simtip.detect.subpixel.tip import TipFit

MOST_TILT, BESIDE_PX = 0.35, 1.0
"""Of an axis along the line of sight that is allowed for, and how much more is left out."""


def without_seam(scenery: Scenery, fit: TipFit) -> Scenery:
    """Give the pixels without those within the needle where a fitted tip meets the shaft."""
    placed = scenery.place(fit.family, fit.values)
    u, v = scenery.points(np.arange(len(scenery.value)))
    off = np.abs(placed.z_at(u, v) - placed.depth_px)
    reach = MOST_TILT * placed.half_px + BESIDE_PX
    if placed.depth_px < reach:
        return scenery  # of so blunt a tip nothing would be left
    seam = (off < reach) & (fit.found.cover.whole > WITHIN)
    return replace(scenery, left_out=scenery.left_out | seam, seamless=True)
