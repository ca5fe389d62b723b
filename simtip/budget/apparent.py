"""Where a detector sees a tip that it sees short: how far along the needle, and how differently."""

from __future__ import annotations

import numpy as np

from simtip.camera import StereoRig
from simtip.geometry import Array

PROBE_MM = 1e-3
ROUNDS = 20


def recession(
    apparent_px: Array, true_px: Array, tips_mm: Array, axis: Array, rig: StereoRig
) -> tuple[Array, Array, Array]:
    """Split the way from the true to the apparent tip into a common one and the views' own.

    Parameters
    ----------
    apparent_px, true_px
        (places, 2, 2) left and right, u and v, px.
    tips_mm
        (places, 3) world, mm.
    axis
        (3,) unit, from the tip to the hub.
    rig
        The true one.

    Returns
    -------
    length_mm
        (places,) along the needle at which both views on average see the tip, mm: its recession.
    common_px
        (places, 2, 2) what that moves the tip by in the images.
    own_px
        (places, 2, 2) what is left: the views' mismatch.
    """
    by_view = np.stack([_along(apparent_px[:, k], tips_mm, axis, rig, k) for k in (0, 1)])
    length = by_view.mean(axis=0)
    common = _projected(tips_mm + length[:, None] * axis, rig) - true_px
    return length, common, apparent_px - true_px - common


def _along(apparent_px: Array, tips_mm: Array, axis: Array, rig: StereoRig, view: int) -> Array:
    """Find how far along the axis (places,), mm, the point is that is seen nearest to it."""
    length = np.zeros(len(tips_mm))
    for _ in range(ROUNDS):
        here = _projected(tips_mm + length[:, None] * axis, rig)[:, view]
        ahead = _projected(tips_mm + (length + PROBE_MM)[:, None] * axis, rig)[:, view]
        slope = (ahead - here) / PROBE_MM
        length = length + ((apparent_px - here) * slope).sum(axis=1) / (slope**2).sum(axis=1)
    return length


def _projected(points_mm: Array, rig: StereoRig) -> Array:
    """Give places (n, 2, 2) of points (n, 3) in both images."""
    return np.stack(rig.project(points_mm), axis=1)
