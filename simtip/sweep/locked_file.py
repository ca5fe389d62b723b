"""Files that several processes lock, and may remove while they hold the lock."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl

ATTEMPTS = 10_000
"""At locking a file that others remove meanwhile; without end where file numbers do not last."""


def flock(descriptor: int, *, wait: bool) -> bool:
    """Lock an open file, and say whether that is possible here.

    Raises
    ------
    BlockingIOError
        Another holds it, and this shall not wait.
    """
    if sys.platform == "win32":
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True


def open_locked(path: Path, flags: int, *, wait: bool = True) -> tuple[int, bool]:
    """Open and lock a file that others may remove while they hold the lock.

    Returns
    -------
    tuple
        The descriptor, and whether it is locked; if so, the path still names that file.

    Raises
    ------
    OSError
        It cannot be opened; or another holds it, and this shall not wait.
    """
    for _ in range(ATTEMPTS):
        descriptor = os.open(path, flags | getattr(os, "O_BINARY", 0), 0o666)
        try:
            locked = flock(descriptor, wait=wait)
            if not locked or _names(path, descriptor):
                return descriptor, locked
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
    return os.open(path, flags | getattr(os, "O_BINARY", 0), 0o666), False


def _names(path: Path, descriptor: int) -> bool:
    """Say whether a path still names an open file."""
    try:
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def let_go(descriptor: int, path: Path | None) -> None:
    """Close a file and so free its lock; `path` is removed first, while nobody else has it."""
    try:
        if path is not None:
            with suppress(OSError):
                path.unlink()
            if sys.platform != "win32":
                # A child forked meanwhile would keep it locked.
                fcntl.flock(descriptor, fcntl.LOCK_UN)
    finally:
        os.close(descriptor)


def unlink_if_unlocked(path: Path) -> bool:
    """Remove a file unless another holds its lock, and say whether this call did."""
    try:
        descriptor, locked = open_locked(path, os.O_RDWR, wait=False)
    except OSError:
        return False
    if locked:
        let_go(descriptor, path)
        return not path.exists()
    os.close(descriptor)
    try:
        path.unlink()
    except OSError:
        return False
    return True
