"""What the name of an image file says: which camera, and which view."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal, TypeAlias

Side: TypeAlias = Literal["left", "right"]
Key: TypeAlias = tuple[str | int, ...]

ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
"""Of image files, in small letters."""

SEPARATORS = "_-. "

_FIRST = re.compile(r"left|right", re.IGNORECASE)
_WORD = re.compile(r"(?<![a-z])(left|right)(?![a-z])", re.IGNORECASE)


def is_image(path: Path) -> bool:
    """Say whether a file's ending is that of an image, and the file not a hidden one."""
    return path.suffix.lower() in ENDINGS and not path.name.startswith(".")


def begins_with_side(stem: str) -> bool:
    """Say whether a name begins with left or right."""
    return _FIRST.match(stem) is not None


def side_of(stem: str) -> Side | None:
    """Give the camera that a name speaks of, at its beginning or as a word of its own."""
    found = _FIRST.match(stem) or _WORD.search(stem)
    if found is None:
        return None
    return "left" if found[0].lower() == "left" else "right"


def without_side(stem: str) -> str:
    """Give what is left of a name without left or right: what both images of a view share."""
    found = _FIRST.match(stem) or _WORD.search(stem)
    rest = stem if found is None else f"{stem[: found.start()]}{stem[found.end() :]}"
    return rest.strip(SEPARATORS)


def key_of(rest: str) -> Key:
    """Give a name's parts, numbers as numbers: 2 comes before 10, and 01 is 1.

    Text and numbers take turns, so that any two keys can be compared.
    """
    parts = re.split(r"(\d+)", rest.casefold().strip(SEPARATORS))
    return tuple(int(part) if i % 2 else part for i, part in enumerate(parts))
