"""An end for trials that take too long: the process ends itself, and its parent goes on."""

from __future__ import annotations

import contextlib
import faulthandler
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import IO


class Limit:
    """The time that a trial may take; a context manager.

    Parameters
    ----------
    seconds
        After which the process ends, whatever it does: a detector in C that never comes back, too.

    Attributes
    ----------
    told
        Descriptor of a file that is told before, see `simtip.sweep.note`; None tells nobody.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self.told: int | None = None
        self._counts = False

    def __enter__(self) -> None:
        """Begin to count."""
        # A thread of C's, which needs no lock of Python's.
        file = _nowhere() if self.told is None else self.told
        faulthandler.dump_traceback_later(self._seconds, exit=True, file=file)
        self._counts = True

    def __exit__(self, *_: object) -> None:
        """Count no more."""
        self._counts = False
        faulthandler.cancel_dump_traceback_later()

    @contextlib.contextmanager
    def paused(self) -> Iterator[None]:
        """Begin to count anew after the block, which may take its time: a render."""
        if not self._counts:  # somebody else's alarm may be set
            yield
            return
        self.__exit__()
        try:
            yield
        finally:
            self.__enter__()


@cache
def _nowhere() -> IO[str]:
    return Path(os.devnull).open("w", encoding="utf-8")
