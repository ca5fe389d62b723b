"""Which pixels of the band get how many samples: most where the derivatives are."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.bound.pose import ViewMoves
from simtip.geometry import Array
from simtip.render.view import Floats
from simtip.spec import SceneSpec

TIP_FACTOR = 16
"""More samples at the tip's edges: few pixels there say nearly all about the place along the axis,
and their edges hardly move when the needle does so."""
INSIDE_SHARE = 4
"""Fewer inside, where only shading changes."""
BESIDE_SHARE = 32
"""Fewer still where the needle was not seen."""
INSIDE_STEPS = 8.0
"""Shading is smooth, and what it changes by in a small step drowns in noise: inside, the needle is
moved so many steps. (On scenes/01 the noise in a tilt's derivative, 17 times its information at one
step, is 0.3 of it at 16, and the information changes by 4 %.)"""
EDGE_PX = 1
"""Around pixels that are partly covered: the views' samples may have missed a little."""
TIP_MARGIN_PX = 4.0


@dataclass(frozen=True, eq=False)
class TipZone:
    """The stretch of the image in which the needle has its tip's shape.

    Attributes
    ----------
    tip_px, axis_px
        (2,) the apex, and the unit direction towards the hub.
    length_px
        Of the tip's shape along it.
    """

    tip_px: Array
    axis_px: Array
    length_px: float

    @classmethod
    def of(cls, moves: ViewMoves, spec: SceneSpec) -> TipZone:
        """Find it in one view."""
        needle = spec.needle.needle()
        rate = float(moves.by_place[0] @ moves.axes.along)  # px per mm
        return cls(moves.tip_px, moves.axis_px, rate * needle.tip.depth_mm(needle.radius_mm))

    def holds(self, u: Array, v: Array) -> NDArray[np.bool_]:
        """Say which pixels lie in it."""
        along = (u - self.tip_px[0]) * self.axis_px[0] + (v - self.tip_px[1]) * self.axis_px[1]
        within = (along > -TIP_MARGIN_PX) & (along < self.length_px + TIP_MARGIN_PX)
        return np.asarray(within, np.bool_)


@dataclass(frozen=True, eq=False)
class Effort:
    """How the pixels of a band are sampled.

    Attributes
    ----------
    samples
        (n,) of each pixel in a replica.
    steps
        (n,) by how many steps the needle is moved for it, where a step moves edges and little else.
    """

    samples: NDArray[np.int64]
    steps: Array


def effort_for(
    band: NDArray[np.uint32], coverage: Floats, zone: TipZone, samples: int, replicas: int
) -> Effort:
    """Decide how to sample a band.

    Parameters
    ----------
    band
        (n,) flat indices of its pixels.
    coverage
        (H, W) by the needle.
    zone
        Where the tip is.
    samples
        Of a pixel at an edge, all replicas together.
    replicas
        How many.
    """
    partly = ((coverage > 0) & (coverage < 1)).astype(np.uint8)
    edge = cv2.dilate(partly, np.ones((2 * EDGE_PX + 1,) * 2, np.uint8)).reshape(-1)[band] > 0
    covered = coverage.reshape(-1)[band] > 0
    v, u = np.divmod(band.astype(np.float64), coverage.shape[1])
    each = max(1, samples // replicas)
    share = np.where(edge, 1, np.where(covered, INSIDE_SHARE, BESIDE_SHARE))
    found = np.maximum(each // share, 1)
    found[edge & zone.holds(u, v)] = each * TIP_FACTOR
    return Effort(found.astype(np.int64), np.where(edge, 1.0, INSIDE_STEPS))
