"""Records of a log, framed so that one cut short is skipped, and no other."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from simtip.sweep.cache_items import in_blocks
from simtip.sweep.locked_file import open_locked


def framed(payload: bytes) -> bytes:
    """Give a record: it begins a line, so that one cut short does not spoil the next.

    Raises
    ------
    ValueError
        There is a line feed in it.
    """
    if b"\n" in payload:
        raise ValueError("a record of a log is one line")
    return b"\n%d %08x %s" % (len(payload), zlib.crc32(payload), payload)


def records(data: bytes) -> Iterator[str]:
    """Give what the whole records of a log say."""
    for record in data.split(b"\n"):
        parts = record.split(b" ", 2)
        if len(parts) == 3 and framed(parts[2])[1:] == record:
            with suppress(UnicodeDecodeError):
                yield parts[2].decode("utf-8", "surrogatepass")


def append(path: Path, record: bytes) -> int:
    """Write a record at the end of a log in one go, and give the bytes that it added on the disk.

    Raises
    ------
    OSError
        It cannot be written.
    """
    descriptor, _ = open_locked(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    try:
        before = os.fstat(descriptor).st_size
        os.write(descriptor, record)
        return in_blocks(os.fstat(descriptor).st_size) - in_blocks(before)
    finally:
        os.close(descriptor)


def added(path: Path, read_bytes: int) -> tuple[bytes, int]:
    """Read what a log has beyond what was read before, and say up to where that is whole, bytes.

    A log that cannot be read has nothing; one that was begun anew is read from its beginning.
    """
    try:
        with path.open("rb") as stream:
            if os.fstat(stream.fileno()).st_size < read_bytes:
                read_bytes = 0
            stream.seek(read_bytes)
            data = stream.read()
    except OSError:
        return b"", 0
    return data, read_bytes + max(data.rfind(b"\n"), 0)
