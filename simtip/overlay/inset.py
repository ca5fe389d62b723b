"""The enlarged block of pixels around the tips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.geometry import Array
from simtip.overlay.marks import WHITE, Marks, Picture, draw_marks
from simtip.overlay.room import HIDES_A_TIP, Box, Room

SHARE = 1 / 3  # of the image's shorter side
SOURCE_PX = 53
LEAST_SOURCE_PX = 15
LEAST_FACTOR = 3


@dataclass(frozen=True)
class Inset:
    """A block of source pixels, each shown as ``factor`` x ``factor`` pixels at ``box``."""

    source: Box
    factor: int
    box: Box
    frame: int  # breadth of the frame's black line, px

    def point(self, point: Array) -> Array:
        """Map a point of the image to px of the inset.

        The left edge of source pixel u0, at u0 - 0.5, is the left edge of the inset, at -0.5.
        """
        corner = np.array([self.source.u0, self.source.v0]) - 0.5
        return (point - corner) * self.factor - 0.5

    def marks(self, marks: Marks) -> Marks:
        """Map all marks; a line keeps its direction, its distance from a point is magnified."""
        true, detected = (p if p is None else self.point(p) for p in (marks.true, marks.detected))
        line = marks.line
        if line is not None:
            normal = line[:2]
            line = np.append(normal, self.factor * line[2] - normal @ self.point(np.zeros(2)))
        return Marks(true, detected, line, marks.axis, marks.detected_axis)

    def outline_source(self, view: Picture) -> None:
        """Draw a frame around the block in the image."""
        inside = self.source.cut(view).copy()
        self.source.grown(self.frame).cut(view)[...] = 0
        self.source.cut(view)[...] = inside

    def draw(self, view: Picture, clean: Picture, marks: Marks, unit: float) -> None:
        """Enlarge the clean pixels, mark them, and paste them in with a frame around."""
        k = self.factor
        enlarged = self.source.cut(clean).repeat(k, axis=0).repeat(k, axis=1)
        # Fine marks, so that the pixels under them are seen.
        stroke, halo = max(1.0, 1.4 * unit), max(0.5, 0.5 * unit)
        draw_marks(enlarged, self.marks(marks), reach=5 * k, stroke=stroke, halo=halo)
        self.box.grown(3 * self.frame).cut(view)[...] = WHITE
        self.box.grown(self.frame).cut(view)[...] = 0
        self.box.cut(view)[...] = enlarged


def plan_inset(room: Room, marks: Marks, shape: tuple[int, ...], unit: float) -> Inset | None:
    """Choose what to enlarge, how much and where; None if nothing can be or there is no room."""
    tips = marks.tips(shape)
    target = int(min(shape[:2]) * SHARE)
    side = min(SOURCE_PX, target // LEAST_FACTOR)
    if not tips or side < LEAST_SOURCE_PX:
        return None
    if 1.5 * np.ptp(tips, axis=0).max() + 16 > side:  # too far apart: the true tip
        tips = tips[:1]
    u0, v0 = np.rint(np.mean(tips, axis=0) - (side - 1) / 2).astype(int).tolist()
    u0, v0 = min(max(0, u0), shape[1] - side), min(max(0, v0), shape[0] - side)
    source = Box(u0, v0, u0 + side, v0 + side)
    room.keep(source)
    factor, frame = target // side, max(1, round(0.8 * unit))
    framed_px = side * factor + 6 * frame
    cost, framed = room.corner((framed_px, framed_px), "tr br tl bl")
    if cost >= HIDES_A_TIP:
        return None
    room.keep(framed)
    return Inset(source, factor, framed.grown(-3 * frame), frame)
