"""Where a cache keeps what, under names that cannot lead out of its folder."""

from __future__ import annotations

import re
from pathlib import Path

LAYOUT = "v1"
TEMPORARY = "tmp"
LOCKS = "locks"
LOG_ENDING = ".log"
KIND = re.compile(r"[a-z]+")
KEY = re.compile(r"[0-9a-f]{16,64}")


def root_of(folder: Path) -> Path:
    """Give the folder in a cache's folder in which all lies that is laid out like this."""
    return folder / LAYOUT


def place_of(root: Path, kind: str, key: str) -> Path:
    """Give the folder of an entry.

    Raises
    ------
    ValueError
        It is no kind, or no key.
    """
    check_kind(kind)
    if KEY.fullmatch(key) is None:
        raise ValueError(f"{key!r} is no key of a cache: 16 to 64 hexadecimal digits")
    return root / kind / key[:2] / key


def log_of(root: Path, kind: str, key: str) -> Path:
    """Give the file of a log; raises as `place_of` does."""
    place = place_of(root, kind, key)
    return place.with_name(place.name + LOG_ENDING)


def lock_of(root: Path, kind: str, key: str) -> Path:
    """Give the file by which an entry is locked; raises as `place_of` does."""
    return root / LOCKS / f"{kind}-{place_of(root, kind, key).name}"


def is_kind(name: str) -> bool:
    """Say whether it is a name of a kind."""
    return KIND.fullmatch(name) is not None and name not in {TEMPORARY, LOCKS}


def check_kind(kind: str) -> None:
    """Refuse a name that is none of a kind; raises ValueError."""
    if not is_kind(kind):
        raise ValueError(f"{kind!r} is no kind of a cache: small letters")
