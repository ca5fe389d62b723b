"""What a page is made of. All texts are plain: whoever writes them into HTML escapes them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from simtip.report.style import Drawn

Tone = Literal["plain", "good", "bad"]


@dataclass(frozen=True)
class Fact:
    """A number that is read first: its name, the number with its unit, and a remark."""

    name: str
    value: str
    remark: str = ""
    tone: Tone = "plain"


@dataclass(frozen=True)
class Facts:
    """Some numbers beside each other."""

    facts: Sequence[Fact]
    shape: str = "facts"


@dataclass(frozen=True)
class Words:
    """Paragraphs; as a note they stand apart."""

    paragraphs: Sequence[str]
    note: bool = False
    shape: str = "words"


@dataclass(frozen=True)
class Grid:
    """A table.

    Attributes
    ----------
    caption
        Its title.
    heads
        Of the columns.
    rows
        Cells as texts.
    strong
        Numbers of the rows that count most.
    """

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    strong: Sequence[int] = ()
    shape: str = "grid"

    @property
    def numeric(self) -> list[bool]:
        """Which columns hold numbers: they are set flush right."""
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.heads)
        return [any(column) and all(map(_looks_like_number, column)) for column in columns]


_NUMBERS = re.compile(
    "(?:[-+\N{MINUS SIGN}\N{PLUS-MINUS SIGN}\\d\N{NARROW NO-BREAK SPACE}.,/ ]+"
    "(?:e[-+\N{MINUS SIGN}]?\\d+)?"
    " ?(?:mm|px|%|s|\N{MICRO SIGN}m)?|\\[.*\\].*|\N{EN DASH})?"
)


def _looks_like_number(cell: str) -> bool:
    return _NUMBERS.fullmatch(cell) is not None


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure.

    Attributes
    ----------
    name
        Of the file, if figures are written; unlike all others of a page.
    title
        What it shows.
    figure
        Black on white; themed where it is put into the page.
    """

    name: str
    title: str
    figure: Drawn
    shape: str = "drawing"


@dataclass(frozen=True)
class Layer:
    """A picture file as part of a view: its data URI, the corner's and its size in px."""

    uri: str
    u: float
    v: float
    width: int
    height: int


@dataclass(frozen=True)
class View:
    """One camera's picture with its marks, in px of the whole image.

    Attributes
    ----------
    title
        E.g. "left".
    width, height
        Of the image, px.
    layers
        Pictures, the last on top.
    focus
        (u, v, width, height) that is shown first.
    true, detected
        Tips; None where there is none.
    axis
        Direction from the true tip to the hub.
    line
        a, b, c of the epipolar line a u + b v + c = 0.
    caption
        Errors, in words.
    """

    title: str
    width: int
    height: int
    layers: Sequence[Layer]
    focus: tuple[float, float, float, float]
    true: tuple[float, float] | None = None
    detected: tuple[float, float] | None = None
    axis: tuple[float, float] | None = None
    line: tuple[float, float, float] | None = None
    caption: str = ""

    @property
    def line_ends(self) -> tuple[float, float, float, float] | None:
        """Where the epipolar line leaves the image, or None if it passes by it."""
        if self.line is None:
            return None
        a, b, c = self.line
        left, top, right, bottom = -0.5, -0.5, self.width - 0.5, self.height - 0.5
        ends = [(u, -(a * u + c) / b) for u in (left, right) if b]
        ends += [(-(b * v + c) / a, v) for v in (top, bottom) if a]
        inside = [
            (u, v)
            for u, v in ends
            if left - 1e-6 <= u <= right + 1e-6 and top - 1e-6 <= v <= bottom + 1e-6
        ]
        if len(inside) < 2:
            return None
        first, last = min(inside), max(inside)
        return (*first, *last)


@dataclass(frozen=True)
class Views:
    """Pictures beside each other, to be zoomed."""

    title: str
    views: Sequence[View]
    shape: str = "views"


@dataclass(frozen=True)
class Code:
    """A text to be copied or saved under a name."""

    title: str
    text: str
    name: str = ""
    folded: bool = False
    shape: str = "code"


@dataclass(frozen=True)
class Explorer:
    """What the page's script fills: `simtip.page.explorer` has what it works on.

    Attributes
    ----------
    kind
        "map", "distributions" or "trials".
    """

    kind: str
    shape: str = "explorer"


@dataclass(frozen=True)
class Entry:
    """One of several things of a kind, such as a trial: a title, and what belongs to it."""

    title: str
    remark: str
    parts: Sequence[Part]
    shape: str = "entry"


Part: TypeAlias = Facts | Words | Grid | Drawing | Views | Code | Explorer | Entry


@dataclass(frozen=True)
class Section:
    """A part of a page with a heading of its own; the name is its anchor."""

    name: str
    title: str
    parts: Sequence[Part]


@dataclass(frozen=True)
class Page:
    """A page.

    Attributes
    ----------
    title
        Of what it tells.
    kind
        Of the folder: "sweep".
    verdict
        The result in a sentence or two.
    facts
        The numbers that are read first.
    sections
        In order; where it all comes from stands last.
    data
        What the explorers work on: a name, and bytes for the page's script.
    settings
        For the script, too; plain data.
    still
        Draws what the script draws, for those who want files.
    """

    title: str
    kind: str
    verdict: str
    facts: Sequence[Fact]
    sections: Sequence[Section]
    data: dict[str, bytes] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    still: Callable[[], Sequence[Drawing]] = tuple

    def all_figures(self) -> list[Drawing]:
        """Give all figures, those of the page first."""
        own = [part for one in self.sections for part in one.parts if isinstance(part, Drawing)]
        return [*own, *self.still()]
