"""What a worker is at, told in a file that outlives it: which trial ended its process, and how."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

HEAD_BYTES = 21
"""The trial's number, and a line feed. What `faulthandler` has to say follows."""


class Note:
    """Written by a worker; a context manager.

    Parameters
    ----------
    path
        The file; None, or a folder that this machine does not have, writes nothing.
    """

    def __init__(self, path: str | None) -> None:
        self._path = path
        self.descriptor: int | None = None

    def __enter__(self) -> Self:
        """Begin it."""
        if self._path is not None:
            with suppress(OSError):
                self.descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        return self

    def at(self, trial: int) -> None:
        """Say which trial comes now."""
        if self.descriptor is not None:
            with suppress(OSError):
                os.lseek(self.descriptor, 0, os.SEEK_SET)
                os.write(self.descriptor, b"%020d\n" % trial)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Remove it if all went well."""
        if self.descriptor is not None and self._path is not None:
            os.close(self.descriptor)
            if kind is None:
                with suppress(OSError):
                    Path(self._path).unlink()


@dataclass(frozen=True)
class Last:
    """What a note says: the trial that was the last, and whether its time ran out."""

    trial: int
    timed_out: bool


def read_note(path: str | None) -> Last | None:
    """Read and remove what a process that died has left; None if nothing is known."""
    if path is None:
        return None
    try:
        said = Path(path).read_bytes()
        Path(path).unlink()
        return Last(int(said[:HEAD_BYTES]), b"Timeout" in said[HEAD_BYTES:])
    except (OSError, ValueError):
        return None
