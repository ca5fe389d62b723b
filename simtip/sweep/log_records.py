"""Records of a log, framed so that one cut short is skipped, and no other."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import suppress


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
