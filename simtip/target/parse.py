"""A target's text, such as ``chessboard:11x8:6``, to the target."""

from __future__ import annotations

import re

from simtip.errors import InputError
from simtip.target.charuco import Charuco
from simtip.target.chessboard import Chessboard
from simtip.target.circles import AsymmetricCircles, CircleGrid
from simtip.target.target import Target

FORMS = {
    "chessboard": "chessboard:COLUMNSxROWS:SQUARE_MM",
    "charuco": "charuco:COLUMNSxROWS:SQUARE_MM:MARKER_MM[:DICTIONARY]",
    "circles": "circles:COLUMNSxROWS:SPACING_MM:DIAMETER_MM",
    "asymmetric": "asymmetric:COLUMNSxROWS:SPACING_MM:DIAMETER_MM",
}
"""The form of each family's text."""

EXAMPLES = {
    "chessboard": "chessboard:11x8:6 (inner corners)",
    "charuco": "charuco:12x9:6:4.5:DICT_4X4_100 (squares)",
    "circles": "circles:11x8:6:3",
    "asymmetric": "asymmetric:4x11:6:3",
}

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def parse_target(text: str) -> Target:
    """Read a target from its text; ``str`` of the result gives the text back.

    Parameters
    ----------
    text
        One of `FORMS`, or ``chessboard`` alone for the paper's; spaces around it do not matter, nor
        does the case of the family.

    Raises
    ------
    InputError
        Another form, or sizes that make no target.
    """
    family, *parts = text.strip().split(":")
    family = family.strip().lower()
    if family not in FORMS:
        raise InputError(
            f"no family of targets is called {family!r}",
            field="target",
            remedy="give " + ", ".join(EXAMPLES.values()),
        )
    if family == Chessboard.family and not parts:
        return Chessboard()  # the paper's
    least, most = {"chessboard": (2, 2), "charuco": (3, 4)}.get(family, (3, 3))
    if not least <= len(parts) <= most:
        raise InputError(
            f"{text.strip()!r} has {len(parts)} parts after the family, not"
            f" {least if least == most else f'{least} or {most}'}",
            field="target",
            remedy=f"the form is {FORMS[family]}, e.g. {EXAMPLES[family]}",
        )
    columns, rows = _counts(parts[0], family)
    lengths = [_length(part, family) for part in parts[1:3]]
    if family == "chessboard":
        return Chessboard(columns, rows, lengths[0])
    if family == "charuco":
        named = (part.strip().upper() for part in parts[3:])
        return Charuco(columns, rows, lengths[0], lengths[1], *named)
    kind = CircleGrid if family == "circles" else AsymmetricCircles
    return kind(columns, rows, lengths[0], lengths[1])


def _counts(part: str, family: str) -> tuple[int, int]:
    match = re.fullmatch(r"\s*(\d{1,6})\s*[xX]\s*(\d{1,6})\s*", part, re.ASCII)
    if match is None:
        raise InputError(
            f"{part.strip()!r} is no COLUMNSxROWS such as 11x8",
            field="target",
            remedy=f"the form is {FORMS[family]}",
        )
    return int(match[1]), int(match[2])


def _length(part: str, family: str) -> float:
    if NUMBER.fullmatch(part.strip()) is None:
        raise InputError(
            f"{part.strip()!r} is no length in mm such as 6 or 4.5",
            field="target",
            remedy=f"the form is {FORMS[family]}",
        )
    return float(part)
