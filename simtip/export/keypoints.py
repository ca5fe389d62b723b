"""Points of a needle in an image, and whether they are seen there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from simtip.export.tracer import Tracer
from simtip.geometry import Array
from simtip.image_sets import NeedlePair
from simtip.needle import Needle

if TYPE_CHECKING:
    from simtip.render.surfaces import Surfaces

UP_MM = 10.0
"""How far up the axis from the foremost point the second point lies."""

NAMES = ("tip", "axis_10mm")

ABSENT, HIDDEN, SEEN = 0, 1, 2
"""COCO's flags: not labelled (x = y = 0), labelled and not visible, labelled and visible."""


@dataclass(frozen=True, eq=False)
class MarkedView:
    """What is marked in one image.

    Attributes
    ----------
    surfaces
        Which pixels show the needle.
    places_px
        (2, 2) where the tip and the point up the axis are.
    flags
        (2,) of each.
    """

    surfaces: Surfaces
    places_px: Array
    flags: tuple[int, int]


def marked(pair: NeedlePair, tracer: Tracer) -> tuple[MarkedView, MarkedView]:
    """Find the needle's pixels and points in both images of a pair.

    The tip is seen if it lies in the image and nothing hides it: neither the needle's own body nor
    another thing. The other point lies inside the needle: there, only other things count.
    """
    truth, up = pair.truth, up_the_axis(pair.truth.needle)
    points = np.stack([truth.tip_mm, truth.tip_mm if up is None else truth.T_wn.apply(up)])
    left, right = tracer.trace(pair.spec, truth.rig, points)
    views = []
    for surfaces, camera, T_cw, own in zip(
        (left, right),
        (truth.rig.left, truth.rig.right),
        pair.poses,
        (truth.left, truth.right),
        strict=True,
    ):
        places = camera.project(T_cw.apply(points))
        places[0] = own.tip_px
        inside = camera.contains(places)
        free = ~surfaces.obstructed
        flags = (
            _flag(inside=bool(inside[0]), seen=bool(free[0]) and own.tip_visible),
            ABSENT if up is None else _flag(inside=bool(inside[1]), seen=bool(free[1])),
        )
        views.append(MarkedView(surfaces, places, flags))
    return views[0], views[1]


def up_the_axis(needle: Needle) -> Array | None:
    """Give the point (3,) on the axis, needle frame, mm; None on a needle that is too short."""
    if needle.length_mm < UP_MM:
        return None
    point = np.array([0.0, 0.0, UP_MM])
    return point if needle.bend is None else needle.bend.apply(point)


def _flag(*, inside: bool, seen: bool) -> int:
    return ABSENT if not inside else SEEN if seen else HIDDEN
