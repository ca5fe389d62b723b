"""Ctrl-C in the command line: one line and no traceback, whenever it comes and however often.

Little is imported here, for this has to be at work before anything else is.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

INTERRUPTED = 130
"""Exit code after SIGINT, as shells have it: 128 + 2."""

NOTHING_WRITTEN = "interrupted; nothing was written"

AT_ONCE_S = 0.5
"""Ctrl-C within this time of another is the same one: what it has begun to end shall end."""

AGAIN_S = 0.05


class Presses:
    """How often Ctrl-C was pressed: `count`."""

    def __init__(self) -> None:
        self.count = 0


class _Taken:
    """Takes Ctrl-C for the command line, in one of three ways."""

    def __init__(self) -> None:
        self._last_s = -AT_ONCE_S

    def leave(self, *_: object) -> None:
        """End the process: nothing is begun that would need an end."""
        with suppress(OSError):
            os.write(2, f"simtip: {NOTHING_WRITTEN}\n".encode())
        os._exit(INTERRUPTED)

    def interrupt(self, *_: object) -> None:
        """Let what is at work clean up."""
        if self.is_new():
            raise KeyboardInterrupt

    def is_new(self) -> bool:
        """Say whether this is more than one of several in quick succession."""
        now = time.monotonic()
        new = now - self._last_s >= AT_ONCE_S
        self._last_s = now if new else self._last_s
        return new

    def again(self, told: sys.UnraisableHookArgs) -> None:
        """Let one that came where it cannot be raised, such as in a finaliser, come once more."""
        if not issubclass(told.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(told)
            return
        self._last_s = -AT_ONCE_S
        main = threading.main_thread().ident
        if main is not None and hasattr(signal, "pthread_kill"):
            later = threading.Timer(AGAIN_S, signal.pthread_kill, (main, signal.SIGINT))
            later.daemon = True
            later.start()


_TAKEN = _Taken()


def take_over() -> None:
    """Take Ctrl-C from now on: at first, before anything is begun, it ends the process."""
    signal.signal(signal.SIGINT, _TAKEN.leave)
    sys.unraisablehook = _TAKEN.again


def let_clean_up() -> None:
    """Let Ctrl-C be a KeyboardInterrupt, once however quickly it is repeated."""
    signal.signal(signal.SIGINT, _TAKEN.interrupt)


@contextmanager
def nothing_begun() -> Iterator[None]:
    """Say that nothing in the block would need an end. Without `take_over` this has no effect."""
    if signal.getsignal(signal.SIGINT) != _TAKEN.interrupt:
        yield
        return
    signal.signal(signal.SIGINT, _TAKEN.leave)
    try:
        yield
    finally:
        let_clean_up()


@contextmanager
def counted() -> Iterator[Presses]:
    """Only count Ctrl-C within the block, which looks at the count where it can be left.

    In a thread other than the main one, which Ctrl-C does not reach, nothing is counted.
    """
    presses = Presses()
    if threading.current_thread() is not threading.main_thread():
        yield presses
        return

    def count(*_: object) -> None:
        presses.count += _TAKEN.is_new()

    before = signal.signal(signal.SIGINT, count)
    try:
        yield presses
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)


def no_more() -> None:
    """Take no more of them: all is said, and what is left is to leave. See `nothing_begun`."""
    if signal.getsignal(signal.SIGINT) in (_TAKEN.leave, _TAKEN.interrupt):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
