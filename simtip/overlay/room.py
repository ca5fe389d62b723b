"""Where in a picture a box hides least."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from simtip.geometry import Array
from simtip.overlay.marks import Marks, Picture

HIDES_A_TIP = 100
"""A place of this cost or more covers a tip or something else that must be seen."""
_HIDES_THE_NEEDLE = 10
_HIDES_AN_OBJECT = 5
_HIDES_THE_LINE = 1


@dataclass(frozen=True)
class Box:
    """Pixels u0 <= u < u1, v0 <= v < v1."""

    u0: int
    v0: int
    u1: int
    v1: int

    def cut(self, picture: Picture) -> Picture:
        """Give a view of these pixels, as far as the picture has them."""
        return picture[max(0, self.v0) : max(0, self.v1), max(0, self.u0) : max(0, self.u1)]

    def grown(self, by: int) -> Box:
        """Give the box with a margin around."""
        return Box(self.u0 - by, self.v0 - by, self.u1 + by, self.v1 + by)

    def crossed_by(self, line: Array) -> bool:
        """Say whether a line passes over any of the pixels."""
        corners = [(u, v, 1.0) for u in (self.u0, self.u1) for v in (self.v0, self.v1)]
        sides = (np.array(corners) - (0.5, 0.5, 0)) @ line
        return bool(sides.min() < 0 < sides.max())


class Room:
    """A picture's corners, and what in the picture is to be seen."""

    def __init__(self, picture: Picture, marks: Marks, unit: float) -> None:
        self._gray: Picture = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)
        self._line = marks.line
        self._margin, clear = round(12 * unit), round(20 * unit)
        self._cost = np.zeros_like(self._gray)
        tips = [np.rint(tip).astype(int) for tip in marks.tips(picture.shape)]
        if tips and marks.axis is not None:
            far = tips[0] + np.rint(sum(picture.shape) * marks.axis).astype(int)
            ends = (tips[0].tolist(), far.tolist())
            cv2.line(self._cost, *ends, (_HIDES_THE_NEEDLE,), 2 * clear + 1)
        for tip in tips:
            cv2.circle(self._cost, tip.tolist(), clear, (HIDES_A_TIP,), cv2.FILLED)

    def keep(self, box: Box) -> None:
        """Let nothing cover these pixels."""
        box.grown(self._margin // 2).cut(self._cost)[...] = HIDES_A_TIP

    def corner(self, size: tuple[int, int], order: str) -> tuple[float, Box]:
        """Give cost and place of a box (width, height) in the cheapest corner (``tl``, ...).

        Of equal ones the first. The cost is infinite where the box does not fit.
        """
        u1, v1 = (n - self._margin for n in self._gray.shape[::-1])
        u = {"l": self._margin, "r": u1 - size[0]}
        v = {"t": self._margin, "b": v1 - size[1]}
        if min(u["r"], v["b"]) < 0:
            return math.inf, Box(0, 0, 0, 0)
        places = [(u[name[1]], v[name[0]]) for name in order.split()]
        boxes = [Box(u0, v0, u0 + size[0], v0 + size[1]) for u0, v0 in places]
        costs = [self._cost_of(box) for box in boxes]
        return min(costs), boxes[costs.index(min(costs))]

    def _cost_of(self, box: Box) -> int:
        hidden = cv2.resize(box.cut(self._gray), (32, 32), interpolation=cv2.INTER_AREA)
        an_object = bool(np.ptp(hidden) > 64)  # of 255: more than uneven light
        line = self._line is not None and box.crossed_by(self._line)
        kept = int(box.cut(self._cost).max())
        return kept + _HIDES_AN_OBJECT * an_object + _HIDES_THE_LINE * line
