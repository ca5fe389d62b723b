"""What killed processes leave in a cache: unfinished folders and files of locks, told by names."""

from __future__ import annotations

import os
import re
import secrets
import shutil
import socket
import time
from pathlib import Path

from simtip.sweep.cache_items import listed, size_of
from simtip.sweep.cache_layout import LOCKS, TEMPORARY
from simtip.sweep.locked_file import unlink_if_unlocked

DAY_S = 86400.0


def temporary_in(root: Path) -> Path:
    """Give the name of a folder to make, on the cache's file system, that nobody else knows.

    Raises
    ------
    OSError
        The folder that it shall lie in cannot be made.
    """
    folder = root / TEMPORARY
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{_owner()}-{secrets.token_hex(8)}"


def remove_leftovers(root: Path) -> int:
    """Remove unfinished folders of processes that are gone, and files of locks that nobody holds.

    Folders of other machines and containers are removed when they are a day old.

    Returns
    -------
    int
        Bytes freed.
    """
    freed = 0
    for found in listed(root / TEMPORARY):
        if _is_left_over(found):
            size = size_of(Path(found.path))
            shutil.rmtree(found.path, ignore_errors=True)
            freed += 0 if os.path.lexists(found.path) else size
    for found in listed(root / LOCKS):
        unlink_if_unlocked(Path(found.path))
    return freed


def _owner() -> str:
    """Give a name of this process that is unlike those of other machines and containers."""
    host = re.sub(r"[^A-Za-z0-9.]", "_", socket.gethostname())[:64]
    try:
        # Containers that share a machine's name may each have a process of this number.
        namespace = Path("/proc/self/ns/pid").stat().st_ino
    except OSError:
        namespace = 0
    return f"{host}-{namespace}-{os.getpid()}"


def _is_left_over(found: os.DirEntry[str]) -> bool:
    try:
        if time.time() - found.stat(follow_symlinks=False).st_mtime > DAY_S:
            return True
    except OSError:
        return False
    owner = found.name.rpartition("-")[0]
    place, _, number = owner.rpartition("-")
    if place != _owner().rpartition("-")[0] or not re.fullmatch("[0-9]{1,10}", number):
        return False
    return not _is_alive(int(number))


def _is_alive(process: int) -> bool:
    if os.name != "posix":
        return True  # elsewhere the signal 0 is no mere question
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass  # somebody else's
    return True
