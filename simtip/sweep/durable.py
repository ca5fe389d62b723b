"""Files that are on the disk before anybody relies on them."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from simtip.output_folder import PREFIX

TEMPORARY = f"{PREFIX}table-"
"""Files that are not whole yet begin with this."""


@contextmanager
def appearing(target: Path) -> Iterator[BinaryIO]:
    """Give a stream to a file that gets its name when all of it is on the disk."""
    temporary = target.parent / f"{TEMPORARY}{secrets.token_hex(8)}"
    try:
        with temporary.open("xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(target)
    except BaseException:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise
    synchronise_names(target.parent)


def synchronise(path: str | Path) -> None:
    """See a file, or the names in a folder, safely onto the disk: the power may fail.

    Raises
    ------
    OSError
        The disk is full, for example, which some file systems find only now.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def synchronise_names(folder: Path) -> None:
    """See the names in a folder onto the disk, where that can be done."""
    if os.name == "posix":
        with suppress(OSError):  # not every file system can
            synchronise(folder)


def write_durably(target: Path, data: bytes) -> None:
    """Write a file so that it is whole, or as it was before, whatever happens when."""
    with appearing(target) as stream:
        stream.write(data)
