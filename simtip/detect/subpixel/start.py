"""A first idea of a tip's shape, from the edges of its rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array

OFF_PX = 1.2
"""An edge that lies so far inside the shaft's belongs to the tip."""

LAST_ROWS = 3


def wedge_start(
    rows: NDArray[np.intp], left: Array, right: Array, axis_u: Array, half_px: Array, tilt: float
) -> tuple[float, Array]:
    """Give the last row, and a wedge's shape in half widths.

    The shape is x, left length, right length, and how far the left and the right edge lie visibly
    within the shaft's: the latter two are shorter.

    Parameters
    ----------
    rows, left, right
        (n,) rows that show the needle, and u of its edges there, NaN where none was seen.
    axis_u, half_px
        (n,) u of the axis, and half width across it.
    tilt
        Length along the axis of one row.
    """
    seen = np.flatnonzero(np.isfinite(left) & np.isfinite(right))
    if not len(seen):
        return float(rows[-1]) + 0.5, np.array([0.0, 1.0, 1.0, 1.0, 1.0])
    last = seen[-LAST_ROWS:]
    v_end = float(rows[seen[-1]]) + 0.5
    half = float(half_px[seen[-1]])
    x = float(np.mean((left + right)[last] / 2 - axis_u[last])) / (half * tilt)
    inside_left = left - (axis_u - half_px * tilt) > OFF_PX
    inside_right = (axis_u + half_px * tilt) - right > OFF_PX
    lengths, visible = [], []
    for inside, reach in ((inside_left, 1 + x), (inside_right, 1 - x)):
        outside = np.flatnonzero(~inside[seen])
        begins = rows[seen[outside[-1]]] if len(outside) else rows[seen[0]]
        length = (v_end - float(begins)) * tilt / half
        # The flank is seen from where it has come OFF_PX in.
        share = max(1 - OFF_PX / (half * max(reach, 0.2)), 0.3)
        lengths.append(length / share)
        visible.append(length)
    return v_end, np.array([np.clip(x, -0.95, 0.95), *lengths, *visible])
