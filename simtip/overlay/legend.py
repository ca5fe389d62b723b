"""The legend: title, error, reason and a key to the marks."""

from __future__ import annotations

import math
import textwrap
from typing import TypeAlias

import cv2
import numpy as np

from simtip.overlay.inset import Inset
from simtip.overlay.marks import WHITE, Marks, Picture, blend, draw_marks, is_inside
from simtip.overlay.room import HIDES_A_TIP, Box, Room

Row: TypeAlias = tuple[str, str]
"""A text, and what it is: ``title``, ``text``, or the mark of `Marks` that it explains."""

_FONT = cv2.FONT_HERSHEY_SIMPLEX
_INK = (32, 32, 32)


def draw_legend(
    view: Picture,
    room: Room,
    title: str,
    marks: Marks,
    inset: Inset | None,
    reason: str | None,
    unit: float,
) -> None:
    """Write the fullest legend that fits and hides no tip."""
    head = [(title, "title")] if title.strip() else []
    result = _result(marks, reason)
    for rows in (head + result + _key(marks, inset, view.shape), head + result, result):
        panel = _Panel(rows, unit, view.shape[1])
        cost, box = room.corner(panel.size, "tl bl tr br")
        if rows and cost < HIDES_A_TIP:
            panel.draw(view, box)
            return


def _result(marks: Marks, reason: str | None) -> list[Row]:
    """Write detected - true, px, and the reason."""
    rows = []
    if marks.true is not None and marks.detected is not None:
        du, dv = (marks.detected - marks.true).tolist()
        if marks.axis is None:
            rows.append((f"error: |d| = {math.hypot(du, dv):.2f} px", "text"))
        else:
            u, v = marks.axis.tolist()
            # The zero makes "+0.00" of "-0.00".
            along, across = (round(x, 2) + 0.0 for x in (u * du + v * dv, u * dv - v * du))
            rows += [
                (f"error: along {along:+.2f} px,", "text"),
                (f"across {across:+.2f} px", "text"),
            ]
    if reason is not None:
        prefix = "No tip detected: " if marks.detected is None else ""
        rows.append((prefix + reason, "text"))
    return rows


def _key(marks: Marks, inset: Inset | None, shape: tuple[int, ...]) -> list[Row]:
    rows = []
    for mark, point in (("true", marks.true), ("detected", marks.detected)):
        if point is not None:
            where = "" if is_inside(point, shape) else " (outside the image)"
            what = (
                "tip and axis" if mark == "detected" and marks.detected_axis is not None else "tip"
            )
            rows.append((f"{mark} {what}{where}", mark))
    if marks.line is not None:
        seen = Box(0, 0, shape[1], shape[0]).crossed_by(marks.line)
        rows.append((f"epipolar line{'' if seen else ' (outside the image)'}", "line"))
    if inset is not None:
        rows.append((f"inset: {inset.factor} times as large", "text"))
    return rows


class _Panel:
    """Rows laid out: wrapped, each with the mark before it."""

    def __init__(self, rows: list[Row], unit: float, width: int) -> None:
        self._scale = 0.52 * max(unit, 0.7)
        self._em = self._extent("H")[1]
        self._pad = round(0.9 * self._em)
        self._stroke = max(1.0, 1.7 * unit)
        limit = min(0.42 * max(width, 400 * unit), width - 2 * self._pad - 24 * unit)
        self._rows: list[Row] = []
        for text, kind in rows:
            room = limit - self._indent(kind)
            columns = max(8, int(20 * room / max(1, self._extent("n" * 20, kind)[0])))
            ascii_text = text.encode("ascii", "replace").decode("ascii")
            first, *rest = textwrap.wrap(ascii_text, columns) or [""]
            after = "title" if kind == "title" else "text"
            self._rows += [(first, kind), *((line, after) for line in rest)]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        widths = [self._indent(kind) + self._extent(text, kind)[0] for text, kind in self._rows]
        height = round(self._em * (1.75 * len(self._rows) - 0.75))
        return max(widths, default=0) + 2 * self._pad, height + 2 * self._pad

    def draw(self, view: Picture, box: Box) -> None:
        """Write on a white ground."""
        blend(box.cut(view), WHITE, 0.88)
        em, u = self._em, box.u0 + self._pad
        for i, (text, kind) in enumerate(self._rows):
            v = box.v0 + self._pad + round(1.75 * em * i)
            origin, weight = (u + self._indent(kind), v + em), 1 + (kind == "title")
            cv2.putText(view, text, origin, _FONT, self._scale, _INK, weight, cv2.LINE_AA)
            if self._indent(kind):
                patch = view[max(0, v - round(0.35 * em)) :, u : u + round(1.8 * em)]
                middle = 0.9 * em
                place = (0.0, 1.0, -round(middle)) if kind == "line" else (middle, middle)
                mark = Marks(**{kind: np.array(place)})
                draw_marks(patch, mark, reach=0.9 * em, stroke=self._stroke, halo=0)

    def _indent(self, kind: str) -> int:
        return 0 if kind in {"title", "text"} else round(2.6 * self._em)

    def _extent(self, text: str, kind: str = "text") -> tuple[int, int]:
        """Give a line's width, and its height without what hangs below the line, px."""
        size, _ = cv2.getTextSize(text, _FONT, self._scale, 1 + (kind == "title"))
        return int(size[0]), int(size[1])
