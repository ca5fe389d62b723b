"""Which two files are a ROS pair."""

from __future__ import annotations

import re
from pathlib import Path

from simtip.errors import InputError

ENDINGS = (".yaml", ".yml")
NAMING = "name the two files alike but for left and right, as in left.yaml and right.yaml"

_SIDE = re.compile("left|right", re.IGNORECASE)
_OTHER = {"left": "right", "right": "left"}


def is_folder(path: str | Path) -> bool:
    """Say whether a path is a folder; what is wrong with any other shows when it is opened."""
    try:
        return Path(path).is_dir()
    except OSError:
        return False


def pair_of(path: str | Path) -> tuple[Path, Path]:
    """Give the left and the right file of the pair that a file belongs to, by its name.

    Raises
    ------
    InputError
        The name does not say which side it is.
    """
    file = Path(path)
    sides = _SIDE.findall(file.stem)
    if len(sides) != 1:
        raise InputError(
            "is one half of a pair of ROS files, and its name does not say which",
            file=path,
            remedy=NAMING,
        )
    other = _OTHER[sides[0].lower()]
    if sides[0].istitle():
        other = other.title()
    elif sides[0].isupper():
        other = other.upper()
    sibling = file.with_name(_SIDE.sub(other, file.stem) + file.suffix)
    return (file, sibling) if sides[0].lower() == "left" else (sibling, file)


def pair_in(folder: str | Path) -> tuple[Path, Path]:
    """Find the one pair in a folder: ``left.yaml``, or the only YAML file named so.

    Raises
    ------
    InputError
        There is none, or more than one, or the folder cannot be read.
    """
    try:
        files = [p for p in sorted(Path(folder).iterdir()) if p.suffix.lower() in ENDINGS]
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", file=folder, remedy="check its permissions"
        ) from error
    plain = [p for p in files if p.stem == "left"]
    named = [p for p in files if [s.lower() for s in _SIDE.findall(p.stem)] == ["left"]]
    found = plain or named
    if len(found) != 1:
        problem = "is a folder with no" if not found else "is a folder with more than one"
        raise InputError(f"{problem} pair of ROS files", file=folder, remedy=f"{NAMING}; or a file")
    return pair_of(found[0])
