"""What lies in a cache: entries and logs, sizes and last uses. Others may change it meanwhile."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from simtip.sweep.cache_layout import KEY, LOG_ENDING, check_kind, is_kind

BLOCK_BYTES = 4096
"""Every file and every folder is taken to fill whole blocks of this size."""


@dataclass(frozen=True)
class Item:
    """An entry or a log as it was found: its kind, place, size and last use."""

    kind: str
    path: Path
    bytes: int
    used_ns: int


@dataclass(frozen=True)
class Kind:
    """What a cache holds of one kind.

    Attributes
    ----------
    count
        Entries and logs.
    bytes
        On the disk.
    oldest_s, newest_s
        When one of them was last used, s since 1970: the one longest ago, and the latest.
    """

    count: int
    bytes: int
    oldest_s: float
    newest_s: float


def items_in(root: Path, kind: str | None = None) -> Iterator[Item]:
    """Look through a cache, at least that of one kind.

    Raises
    ------
    ValueError
        It is no kind.
    """
    if kind is not None:
        check_kind(kind)
    for place in _folders(root):
        if place.name != kind and not (kind is None and is_kind(place.name)):
            continue
        for shard in _folders(place):
            for found in listed(shard):
                item = _item(place.name, found)
                if item is not None:
                    yield item


def by_kind(items: Iterable[Item]) -> dict[str, Kind]:
    """Sum items up, in the order of the alphabet."""
    found: dict[str, list[Item]] = {}
    for item in items:
        found.setdefault(item.kind, []).append(item)
    return {kind: _summed(found[kind]) for kind in sorted(found)}


def last_use_ns(path: Path) -> int | None:
    """Give when an entry or a log was last used, ns since 1970; None if it is gone."""
    try:
        return path.stat(follow_symlinks=False).st_mtime_ns
    except OSError:
        return None


def listed(folder: Path) -> list[os.DirEntry[str]]:
    """List a folder; one that is gone, or may not be read, has nothing in it."""
    try:
        with os.scandir(folder) as found:
            return list(found)
    except OSError:
        return []


def below(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Give all that is in a folder and in the folders in it."""
    for found in listed(folder):
        yield found
        if _is_folder(found):
            yield from below(Path(found.path))


def size_of(folder: Path) -> int:
    """Give the bytes that a folder and all below it fill on the disk."""
    size = BLOCK_BYTES
    for found in below(folder):
        with suppress(OSError):
            is_folder = _is_folder(found)
            size += (
                BLOCK_BYTES if is_folder else in_blocks(found.stat(follow_symlinks=False).st_size)
            )
    return size


def in_blocks(size: int) -> int:
    """Round bytes up to whole blocks."""
    return -(-size // BLOCK_BYTES) * BLOCK_BYTES


def _folders(folder: Path) -> Iterator[Path]:
    """Give the folders in a folder; links to folders elsewhere are none."""
    for found in listed(folder):
        if _is_folder(found):
            yield Path(found.path)


def _is_folder(found: os.DirEntry[str]) -> bool:
    try:
        return found.is_dir(follow_symlinks=False)
    except OSError:
        return False


def _item(kind: str, found: os.DirEntry[str]) -> Item | None:
    """Give what was found if it is an entry or a log."""
    name, path = found.name, Path(found.path)
    is_log = name.endswith(LOG_ENDING)
    if KEY.fullmatch(name.removesuffix(LOG_ENDING)) is None:
        return None
    try:
        status = found.stat(follow_symlinks=False)
    except OSError:
        return None
    if is_log and stat.S_ISREG(status.st_mode):
        return Item(kind, path, in_blocks(status.st_size), status.st_mtime_ns)
    if not is_log and stat.S_ISDIR(status.st_mode):
        return Item(kind, path, size_of(path), status.st_mtime_ns)
    return None


def _summed(items: list[Item]) -> Kind:
    used_s = [item.used_ns / 1e9 for item in items]
    return Kind(len(items), sum(item.bytes for item in items), min(used_s), max(used_s))
