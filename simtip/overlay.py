"""Pictures on which one sees at a glance whether a detected needle tip is right.

Plain arrays in, plain arrays out; nothing of the simulation or of the detectors is needed. A point
is (u, v) with pixel (0, 0) at the centre of the top-left pixel, here as everywhere. Colours are
those of Okabe and Ito (2008, "Color universal design"), which colour-blind people tell apart, and
each mark has a shape of its own besides.

Marks are painted from their exact distance to each pixel centre. OpenCV's anti-aliased lines are
up to 0.15 px off the place asked for, and wider than asked (measured with OpenCV 5.0).
"""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

Picture: TypeAlias = NDArray[np.uint8]
Floats: TypeAlias = NDArray[np.float64]
Point: TypeAlias = tuple[float, float]
Line: TypeAlias = tuple[float, float, float]
Color: TypeAlias = tuple[int, int, int]

TRUE_COLOR: Color = (0, 114, 178)
"""Blue: the true tip, a cross with an open centre."""
DETECTED_COLOR: Color = (213, 94, 0)
"""Vermilion: the detected tip, a ring with a dot in its centre."""
LINE_COLOR: Color = (204, 121, 167)
"""Reddish purple: the epipolar line."""
_INK: Color = (32, 32, 32)
_WHITE: Color = (255, 255, 255)

_FONT = cv2.FONT_HERSHEY_SIMPLEX
_REGULAR, _BOLD = 1, 2
_NO_BREAK = "\N{NO-BREAK SPACE}"
_HIDES_A_TIP = 100.0
_ROWS_AT_ONCE = 128  # bounds the memory a line takes on a large image


def draw_view(
    image_rgb: NDArray[np.uint8] | NDArray[np.uint16],
    *,
    title: str,
    tip_true_px: ArrayLike | None = None,
    tip_detected_px: ArrayLike | None = None,
    epipolar_line: ArrayLike | None = None,
    axis_px: ArrayLike | None = None,
    reason: str | None = None,
    white_dn: float | None = None,
) -> Picture:
    """Draw the tips of one view over its image, with an enlarged inset and a legend.

    What is None is left out. The inset and the legend go to corners where they hide neither tip
    nor, if it can be had, the needle. In an image too small for them the inset is left out, and of
    the legend first the key, then the title, then the rest; only a reason may hide a tip. A tip
    outside the image is named so in the legend. The given arrays stay as they are.

    Parameters
    ----------
    image_rgb
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16, DN.
    title
        First line of the legend, e.g. ``left``. Characters outside ASCII become ``?``.
    tip_true_px
        (2,) true tip (u, v), px: a blue cross with an open centre.
    tip_detected_px
        (2,) detected tip (u, v), px: a vermilion ring with a dot.
    epipolar_line
        (3,) a, b, c of the line a u + b v + c = 0, px.
    axis_px
        (2,) direction from tip to hub in the image. With it the error is written along the axis
        (positive towards the hub) and across it (positive along (-axis_v, axis_u), which is the
        axis turned 90 degrees clockwise as seen); without it only its length.
    reason
        Why there is no detection, or another remark; long sentences are wrapped.
    white_dn
        DN shown as white; by default the largest of the type (255 or 65535). Give ``4095`` for
        12-bit images in uint16.

    Returns
    -------
    ndarray
        (H, W, 3) uint8, RGB.

    Raises
    ------
    ValueError
        The image is empty or of another shape or type, a number is not finite, the axis or the
        direction of the line is zero, or ``white_dn`` is not above zero.
    """
    clean = _as_rgb8(image_rgb, white_dn)
    marks = _Marks(
        true=_point(tip_true_px, "tip_true_px"),
        detected=_point(tip_detected_px, "tip_detected_px"),
        line=_line(epipolar_line),
        axis=_axis(axis_px),
    )
    unit = _unit(clean)
    view = clean.copy()
    inset = _plan_inset(clean, marks, unit)
    if inset is not None:
        _draw_source_box(view, inset, unit)
    _draw_marks(view, marks, _main_style(unit))
    taken = []
    if inset is not None:
        _draw_inset(view, clean, inset, marks, unit)
        taken.append(inset.box)
    _draw_legend(view, clean, _entries(title, marks, reason, clean), marks, taken)
    return view


def side_by_side(left: Picture, right: Picture) -> Picture:
    """Put two (H, W, 3) uint8 pictures beside each other, tops aligned, with a thin white gap.

    Heights and widths may differ; what the lower one lacks is white.
    """
    pictures = [_as_rgb8(left, None), _as_rgb8(right, None)]
    height = max(p.shape[0] for p in pictures)
    widths = [p.shape[1] for p in pictures]
    gap = max(2, round(max(widths) / 200))
    both = np.full((height, sum(widths) + gap, 3), 255, dtype=np.uint8)
    both[: pictures[0].shape[0], : widths[0]] = pictures[0]
    both[: pictures[1].shape[0], widths[0] + gap :] = pictures[1]
    return both


# What was given, checked


@dataclass(frozen=True)
class _Marks:
    """What is to be drawn, in px of the image it is drawn on."""

    true: Point | None
    detected: Point | None
    line: Line | None
    axis: Point | None

    def tips(self, shape: tuple[int, ...]) -> list[Point]:
        """Give the tips that lie in an image of this shape, the true one first."""
        return [p for p in (self.true, self.detected) if p is not None and _inside(p, shape)]


def _as_rgb8(image: NDArray[np.uint8] | NDArray[np.uint16], white_dn: float | None) -> Picture:
    """Give a new (H, W, 3) uint8 picture; ``white_dn`` becomes 255."""
    a = np.asarray(image)
    if a.dtype.name not in {"uint8", "uint16"}:
        raise ValueError(f"an image is uint8 or uint16, not {a.dtype!s}")
    if a.ndim not in {2, 3} or (a.ndim == 3 and a.shape[2] != 3) or a.size == 0:
        raise ValueError(f"an image is (H, W) or (H, W, 3) with pixels, not {a.shape}")
    most = 255 if a.dtype.name == "uint8" else 65535
    white = float(most if white_dn is None else white_dn)
    if not (white > 0 and math.isfinite(white)):
        raise ValueError(f"white_dn must be above zero, not {white_dn}")
    shades = np.rint(np.clip(np.arange(most + 1) * (255 / white), 0, 255)).astype(np.uint8)
    shown: Picture = shades[a]
    return np.repeat(shown[:, :, None], 3, axis=2) if a.ndim == 2 else shown


def _finite(values: ArrayLike, count: int, name: str) -> list[float]:
    a = np.asarray(values, dtype=np.float64)
    if a.shape != (count,) or not np.isfinite(a).all():
        raise ValueError(f"{name} must be {count} finite numbers, not {a.tolist()}")
    return [float(x) for x in a]


def _point(values: ArrayLike | None, name: str) -> Point | None:
    if values is None:
        return None
    u, v = _finite(values, 2, name)
    return u, v


def _axis(values: ArrayLike | None) -> Point | None:
    if values is None:
        return None
    u, v = _finite(values, 2, "axis_px")
    length = math.hypot(u, v)
    if not length > 0:
        raise ValueError("axis_px must have a length above zero")
    return u / length, v / length


def _line(values: ArrayLike | None) -> Line | None:
    """Scale so that a u + b v + c is the signed distance in px."""
    if values is None:
        return None
    a, b, c = _finite(values, 3, "epipolar_line")
    length = math.hypot(a, b)
    if not length > 0:
        raise ValueError("epipolar_line has no direction: a and b are zero")
    return a / length, b / length, c / length


def _inside(point: Point, shape: tuple[int, ...]) -> bool:
    """Say whether a point lies on the image, whose pixels reach 0.5 px around their centres."""
    return -0.5 <= point[0] < shape[1] - 0.5 and -0.5 <= point[1] < shape[0] - 0.5


def _unit(picture: Picture) -> float:
    """Give the px of this picture that make one px when it is shown about 800 px wide."""
    height, width = int(picture.shape[0]), int(picture.shape[1])
    return max(0.35, min(width / 800.0, height / 450.0))


# Marks


@dataclass(frozen=True)
class _Style:
    """Sizes of the marks, px of the picture drawn on."""

    stroke: float
    halo: float
    gap: float
    reach: float
    radius: float
    dot: float
    line: float


def _main_style(unit: float) -> _Style:
    stroke = max(1.0, 1.7 * unit)
    return _Style(
        stroke=stroke,
        halo=max(0.5, 0.8 * unit),
        gap=13.0 * unit,  # beyond the box around the enlarged block, usually
        reach=24.0 * unit,
        radius=7.5 * unit,
        dot=max(0.7, 1.3 * unit),
        line=max(1.0, 1.4 * unit),
    )


def _inset_style(factor: int, unit: float) -> _Style:
    """Fine marks, so that the pixels under them are seen: sizes follow the source pixels."""
    stroke = max(1.0, 1.4 * unit)
    return _Style(
        stroke=stroke,
        halo=max(0.5, 0.5 * unit),
        gap=1.0 * factor,
        reach=5.0 * factor,
        radius=2.2 * factor,
        dot=max(0.7, 1.3 * unit),
        line=max(1.0, unit),
    )


def _draw_marks(picture: Picture, marks: _Marks, style: _Style) -> None:
    if marks.line is not None:
        _draw_line(picture, marks.line, style)
    if marks.true is not None:
        _draw_cross(picture, marks.true, style)
    if marks.detected is not None:
        _draw_ring(picture, marks.detected, style)


def _draw_cross(picture: Picture, centre: Point, style: _Style) -> None:
    half = style.stroke / 2

    def outside(x: Floats, y: Floats) -> Floats:
        ax, ay = np.abs(x), np.abs(y)
        level = np.hypot(np.maximum(0, np.maximum(style.gap - ax, ax - style.reach)), ay)
        upright = np.hypot(np.maximum(0, np.maximum(style.gap - ay, ay - style.reach)), ax)
        return np.asarray(np.minimum(level, upright) - half)

    extent = style.reach + half
    _paint(picture, centre, outside, TRUE_COLOR, extent=extent, halo=style.halo)


def _draw_ring(picture: Picture, centre: Point, style: _Style) -> None:
    half = style.stroke / 2

    def outside(x: Floats, y: Floats) -> Floats:
        r = np.hypot(x, y)
        return np.asarray(np.minimum(np.abs(r - style.radius) - half, r - style.dot))

    extent = style.radius + half
    _paint(picture, centre, outside, DETECTED_COLOR, extent=extent, halo=style.halo)


def _paint(
    picture: Picture,
    centre: Point,
    outside: Callable[[Floats, Floats], Floats],
    color: Color,
    *,
    extent: float,
    halo: float,
) -> None:
    """Paint a shape and its white halo.

    ``outside`` gives the signed distance (px) of points, relative to the centre, to the shape.
    """
    height, width = picture.shape[:2]
    far = extent + halo + 2
    u0, u1 = max(0, math.floor(centre[0] - far)), min(width, math.ceil(centre[0] + far) + 1)
    v0, v1 = max(0, math.floor(centre[1] - far)), min(height, math.ceil(centre[1] + far) + 1)
    if u0 >= u1 or v0 >= v1:
        return
    x = np.arange(u0, u1, dtype=np.float64)[None, :] - centre[0]
    y = np.arange(v0, v1, dtype=np.float64)[:, None] - centre[1]
    distance = outside(x, y)
    patch = picture[v0:v1, u0:u1]
    _blend(patch, _WHITE, 0.85 * _coverage(distance - halo))
    _blend(patch, color, _coverage(distance))


def _coverage(outside: Floats) -> Floats:
    """Give the share of a pixel inside an edge at this signed distance from its centre."""
    return np.clip(0.5 - outside, 0.0, 1.0)


def _blend(patch: Picture, color: Color, alpha: Floats | float) -> None:
    """Mix a colour into a view of a picture, in place."""
    a = np.asarray(alpha, dtype=np.float64)[..., None]
    patch[...] = np.rint(patch * (1 - a) + np.array(color, dtype=np.float64) * a).astype(np.uint8)


def _draw_line(picture: Picture, line: Line, style: _Style) -> None:
    """Paint the part of a line that crosses the picture; others leave no trace."""
    height, width = picture.shape[:2]
    a, b, c = line
    along_row = a * np.arange(width)[None, :]
    for top in range(0, height, _ROWS_AT_ONCE):
        rows = picture[top : top + _ROWS_AT_ONCE]
        v = np.arange(top, top + rows.shape[0])[:, None]
        outside = np.abs(along_row + (b * v + c)) - style.line / 2
        near = np.nonzero(outside - style.halo < 0.5)
        pixels = rows[near]
        _blend(pixels, _WHITE, 0.4 * _coverage(outside[near] - style.halo))
        _blend(pixels, LINE_COLOR, _coverage(outside[near]))
        rows[near] = pixels


# The inset


@dataclass(frozen=True)
class _Box:
    """Pixels u0 <= u < u1, v0 <= v < v1."""

    u0: int
    v0: int
    u1: int
    v1: int

    def cut(self, picture: Picture) -> Picture:
        return picture[self.v0 : self.v1, self.u0 : self.u1]

    def grown(self, by: int) -> _Box:
        return _Box(self.u0 - by, self.v0 - by, self.u1 + by, self.v1 + by)

    def holds(self, point: Point) -> bool:
        return self.u0 - 0.5 <= point[0] < self.u1 - 0.5 and (
            self.v0 - 0.5 <= point[1] < self.v1 - 0.5
        )

    def meets(self, other: _Box) -> bool:
        return (
            self.u0 < other.u1 and other.u0 < self.u1 and self.v0 < other.v1 and other.v0 < self.v1
        )

    def crossed_by(self, line: Line) -> bool:
        sides = [
            line[0] * u + line[1] * v + line[2]
            for u in (self.u0 - 0.5, self.u1 - 0.5)
            for v in (self.v0 - 0.5, self.v1 - 0.5)
        ]
        return min(sides) < 0 < max(sides)


@dataclass(frozen=True)
class _Inset:
    """A block of source pixels, each shown as ``factor`` x ``factor`` pixels at ``box``."""

    source: _Box
    factor: int
    box: _Box

    def point(self, point: Point | None) -> Point | None:
        """Map a point of the image to px of the inset.

        The left edge of source pixel u0, at u0 - 0.5, is the left edge of the inset, at -0.5.
        """
        if point is None:
            return None
        k = self.factor
        return (
            (point[0] - self.source.u0 + 0.5) * k - 0.5,
            (point[1] - self.source.v0 + 0.5) * k - 0.5,
        )

    def line(self, line: Line | None) -> Line | None:
        """Map a line: its distance from the inset's pixel (0, 0), magnified."""
        if line is None:
            return None
        a, b, c = line
        k = self.factor
        u, v = self.source.u0 - 0.5 + 0.5 / k, self.source.v0 - 0.5 + 0.5 / k
        return a, b, k * (a * u + b * v + c)


_INSET_SHARE = 1 / 3
_INSET_SOURCE_PX = 56
_LEAST_SOURCE_PX = 15
_LEAST_FACTOR = 3


def _plan_inset(clean: Picture, marks: _Marks, unit: float) -> _Inset | None:
    """Choose what to enlarge, how much and where; None if nothing can be or there is no room."""
    tips = marks.tips(clean.shape)
    target = int(min(clean.shape[:2]) * _INSET_SHARE)
    if not tips or target < _LEAST_FACTOR * _LEAST_SOURCE_PX:
        return None
    apart = max(abs(tips[0][0] - tips[-1][0]), abs(tips[0][1] - tips[-1][1]))
    both = math.ceil(apart * 1.5) + 16
    if both > target // _LEAST_FACTOR:  # too far apart: the true tip, or the only one
        tips, both = tips[:1], 0
    factor = max(_LEAST_FACTOR, round(target / max(_INSET_SOURCE_PX, both)))
    while factor > _LEAST_FACTOR and target // factor < both:
        factor -= 1
    source = _source_box(tips, target // factor, clean.shape)
    frame = 3 * _thin(unit)
    side = target // factor * factor + 2 * frame
    kept = [source.grown(round(4 * unit))]
    cost, framed = _Room(clean, marks, unit).corner((side, side), "tr br tl bl", kept)
    return None if cost >= _HIDES_A_TIP else _Inset(source, factor, framed.grown(-frame))


def _thin(unit: float) -> int:
    return max(1, round(0.8 * unit))


def _source_box(tips: list[Point], side: int, shape: tuple[int, ...]) -> _Box:
    """Centre a square block on the tips, moved to lie in the image."""
    u = sum(p[0] for p in tips) / len(tips)
    v = sum(p[1] for p in tips) / len(tips)
    u0 = min(max(0, round(u - (side - 1) / 2)), shape[1] - side)
    v0 = min(max(0, round(v - (side - 1) / 2)), shape[0] - side)
    return _Box(u0, v0, u0 + side, v0 + side)


def _draw_source_box(view: Picture, inset: _Inset, unit: float) -> None:
    _frame(view, inset.source, _thin(unit), _INK)


def _draw_inset(view: Picture, clean: Picture, inset: _Inset, marks: _Marks, unit: float) -> None:
    """Enlarge the clean pixels, mark them, and paste them in with a frame around."""
    k = inset.factor
    enlarged = inset.source.cut(clean).repeat(k, axis=0).repeat(k, axis=1)
    inside = _Marks(
        inset.point(marks.true), inset.point(marks.detected), inset.line(marks.line), marks.axis
    )
    _draw_marks(enlarged, inside, _inset_style(k, unit))
    _draw_scale(enlarged, k, inside, unit)
    inset.box.cut(view)[...] = enlarged
    thin = _thin(unit)
    _frame(view, inset.box, thin, _INK)
    _frame(view, inset.box.grown(thin), 2 * thin, _WHITE)


def _frame(picture: Picture, box: _Box, thickness: int, color: Color) -> None:
    """Draw a frame around the pixels of a box, touching none of them."""
    height, width = picture.shape[:2]
    outer = box.grown(thickness)
    u0, u1 = max(0, outer.u0), min(width, outer.u1)
    v0, v1 = max(0, outer.v0), min(height, outer.v1)
    picture[v0 : max(0, box.v0), u0:u1] = color
    picture[max(0, box.v1) : v1, u0:u1] = color
    picture[v0:v1, u0 : max(0, box.u0)] = color
    picture[v0:v1, max(0, box.u1) : u1] = color


def _draw_scale(enlarged: Picture, factor: int, marks: _Marks, unit: float) -> None:
    """Draw a bar as long as 10 (or 5) source pixels in a free corner of the inset."""
    count = 10 if 10 * factor <= 0.5 * enlarged.shape[1] else 5
    text = _Text(f"{count} px", 0.42 * max(unit, 0.8), _REGULAR)
    pad = max(2, round(3 * unit))
    thick = max(1, round(1.5 * unit))
    width = max(count * factor, text.width) + 2 * pad
    size = (width, text.height + thick + 3 * pad)
    cost, box = _Room(enlarged, marks, 0.2 * unit).corner(size, "bl br tl tr", [])
    if cost >= _HIDES_A_TIP:
        return
    _blend(box.cut(enlarged), _WHITE, 0.8)
    text.put(enlarged, box.u0 + (width - text.width) // 2, box.v0 + pad)
    u0 = box.u0 + (width - count * factor) // 2
    enlarged[box.v1 - pad - thick : box.v1 - pad, u0 : u0 + count * factor] = _INK


# Where there is room


class _Room:
    """Finds corners of a picture where a box hides least."""

    def __init__(self, picture: Picture, marks: _Marks, unit: float) -> None:
        self._height, self._width = picture.shape[:2]
        self._margin = round(12 * unit)
        self._clear = round(20 * unit)
        self._tips = marks.tips(picture.shape)
        self._needle = self._along_axis(marks.axis)
        self._line = marks.line
        self._step = max(1, self._width // 128)
        gray = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        small = (-(-self._width // self._step), -(-self._height // self._step))
        self._coarse = cv2.resize(gray, small, interpolation=cv2.INTER_AREA)

    def corner(
        self, size: tuple[int, int], order: str, taken: Iterable[_Box]
    ) -> tuple[float, _Box]:
        """Give the cost and place of a box (width, height) in the best corner, the first if equal.

        The cost is infinite where the box does not fit, and ``_HIDES_A_TIP`` or more where it
        covers a tip or something taken.
        """
        best = (math.inf, _Box(0, 0, 0, 0))
        u = {"l": self._margin, "r": self._width - self._margin - size[0]}
        v = {"t": self._margin, "b": self._height - self._margin - size[1]}
        if min(u["r"], v["b"]) < 0:
            return best
        taken = list(taken)
        for name in order.split():
            u0, v0 = u[name[1]], v[name[0]]
            box = _Box(u0, v0, u0 + size[0], v0 + size[1])
            cost = self._cost(box, taken)
            if cost < best[0]:
                best = cost, box
        return best

    def _along_axis(self, axis: Point | None) -> list[Point]:
        """Give points of the needle, whose width is not known, from a tip to beyond the border."""
        if axis is None or not self._tips:
            return []
        u, v = self._tips[0]
        return [
            (u + axis[0] * t, v + axis[1] * t)
            for t in np.linspace(0, self._width + self._height, 400)
        ]

    def _cost(self, box: _Box, taken: list[_Box]) -> float:
        wide = box.grown(self._clear)
        s = self._step
        hidden = self._coarse[box.v0 // s : -(-box.v1 // s), box.u0 // s : -(-box.u1 // s)]
        an_object = int(hidden.max()) - int(hidden.min()) > 64  # of 255: more than uneven light
        return (
            _HIDES_A_TIP * any(wide.holds(p) for p in self._tips)
            + _HIDES_A_TIP * any(box.grown(self._margin // 2).meets(t) for t in taken)
            + 10 * any(wide.holds(p) for p in self._needle)
            + 5 * an_object
            + 1 * (self._line is not None and box.crossed_by(self._line))
        )


# The legend


@dataclass(frozen=True)
class _Text:
    """One line of ASCII text."""

    text: str
    scale: float
    weight: int

    @property
    def width(self) -> int:
        return int(cv2.getTextSize(self.text, _FONT, self.scale, self.weight)[0][0])

    @property
    def height(self) -> int:
        """Height of a capital letter, px, the same for all texts of a size."""
        return int(cv2.getTextSize("H", _FONT, self.scale, self.weight)[0][1])

    def put(self, picture: Picture, u0: int, v0: int) -> None:
        """Write with the top left of the capital letters at (u0, v0)."""
        origin = (u0, v0 + self.height)
        cv2.putText(picture, self.text, origin, _FONT, self.scale, _INK, self.weight, cv2.LINE_AA)


@dataclass(frozen=True)
class _Entry:
    """A paragraph of the legend, behind its mark if it has one."""

    text: str
    bold: bool = False
    mark: str = ""


def _entries(title: str, marks: _Marks, reason: str | None, clean: Picture) -> list[list[_Entry]]:
    """Give the legend's paragraphs: in full, and the shorter ones to try where room is short."""
    head = [_Entry(_ascii(title), bold=True)] if title.strip() else []
    result = []
    if marks.true is not None and marks.detected is not None:
        result.append(_Entry(_error_text(marks.true, marks.detected, marks.axis)))
    if reason is not None:
        prefix = "" if marks.detected is not None else "No tip detected: "
        result.append(_Entry(_ascii(prefix + reason)))
    keys = []
    for name, point in (("true", marks.true), ("detected", marks.detected)):
        if point is not None:
            where = "" if _inside(point, clean.shape) else " (outside the image)"
            keys.append(_Entry(f"{name} tip{where}", mark=name))
    if marks.line is not None:
        height, width = clean.shape[:2]
        seen = _Box(0, 0, width, height).crossed_by(marks.line)
        where = "" if seen else " (outside the image)"
        keys.append(_Entry(f"epipolar line{where}", mark="line"))
    return [head + result + keys, head + result, result or head]


def _ascii(text: str) -> str:
    return " ".join(text.split()).encode("ascii", "replace").decode("ascii")


def _error_text(true: Point, detected: Point, axis: Point | None) -> str:
    """Write detected - true in px, with two decimals where all of it is below one."""
    du, dv = detected[0] - true[0], detected[1] - true[1]
    size = math.hypot(du, dv)
    places = 2 if size < 1 else 1
    if axis is None:
        return f"error: |d| = {size:.{places}f} px"
    along = round(axis[0] * du + axis[1] * dv, places) + 0.0  # no "-0.0"
    across = round(axis[0] * dv - axis[1] * du, places) + 0.0
    parts = (f"error: along {along:+.{places}f} px,", f"across {across:+.{places}f} px")
    return " ".join(part.replace(" ", _NO_BREAK) for part in parts)


def _draw_legend(
    view: Picture,
    clean: Picture,
    choices: list[list[_Entry]],
    marks: _Marks,
    taken: list[_Box],
) -> None:
    """Write the fullest legend that fits and hides no tip; at need a reason may hide one."""
    unit = _unit(clean)
    room = _Room(clean, marks, unit)
    for entries in choices:
        panel = _Panel(entries, unit, clean.shape[1])
        cost, box = room.corner(panel.size, "tl bl tr br", taken)
        last = entries is choices[-1] and marks.detected is None
        if entries and (cost < _HIDES_A_TIP or (last and cost < math.inf)):
            panel.draw(view, box)
            return


class _Panel:
    """A legend laid out: wrapped lines, each with the mark before it."""

    def __init__(self, entries: list[_Entry], unit: float, width: int) -> None:
        self._unit = unit
        self._scale = 0.52 * max(unit, 0.7)
        capital = _Text("H", self._scale, _REGULAR)
        self._em = capital.height
        self._pad = round(0.9 * self._em)
        self._key_width = round(2.6 * self._em)
        limit = min(0.42 * max(width, 400 * unit), width - 2 * self._pad - 24 * unit)
        self._rows = [row for entry in entries for row in self._wrap(entry, limit)]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        widest = max((self._indent(mark) + text.width for text, mark in self._rows), default=0)
        height = round(self._em * (1.75 * len(self._rows) - 0.75))
        return widest + 2 * self._pad, height + 2 * self._pad

    def draw(self, view: Picture, box: _Box) -> None:
        _blend(box.cut(view), _WHITE, 0.88)
        for i, (text, mark) in enumerate(self._rows):
            v = box.v0 + self._pad + round(1.75 * self._em * i)
            text.put(view, box.u0 + self._pad + self._indent(mark), v)
            if mark:
                middle = (box.u0 + self._pad + 0.9 * self._em, v + 0.55 * self._em)
                self._draw_key(view, mark, middle)

    def _indent(self, mark: str) -> int:
        return self._key_width if mark else 0

    def _wrap(self, entry: _Entry, limit: float) -> list[tuple[_Text, str]]:
        weight = _BOLD if entry.bold else _REGULAR
        sample = _Text("n" * 20, self._scale, weight)
        columns = max(8, int(20 * (limit - self._indent(entry.mark)) / max(1, sample.width)))
        lines = textwrap.wrap(entry.text, columns) or [""]
        return [
            (_Text(line.replace(_NO_BREAK, " "), self._scale, weight), entry.mark if i == 0 else "")
            for i, line in enumerate(lines)
        ]

    def _draw_key(self, view: Picture, mark: str, middle: Point) -> None:
        em = self._em
        style = _Style(
            stroke=max(1.0, 1.7 * self._unit),
            halo=0.0,
            gap=0.25 * em,
            reach=0.75 * em,
            radius=0.55 * em,
            dot=max(0.7, 1.3 * self._unit),
            line=max(1.0, 1.7 * self._unit),
        )
        if mark == "true":
            _draw_cross(view, middle, style)
        elif mark == "detected":
            _draw_ring(view, middle, style)
        else:
            u, v = round(middle[0] - 0.9 * em), round(middle[1])
            _draw_line(view[:, u : u + round(1.8 * em)], (0.0, 1.0, -float(v)), style)
