"""How a worker that is told to leave (SIGTERM) gets out of what it is at."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class ToldToLeaveError(KeyboardInterrupt):
    """Raised in a worker that is told to leave, so that its programs end and its files are removed.

    It passes where an interrupt by the user passes: through all that guards against a detector's
    faults. It is none of those, so no row is made of it.
    """


def run_until_told(fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
    """Do a job in a worker; told to leave, the worker ends what the job has begun, and itself."""
    try:
        signal.signal(signal.SIGTERM, _leave)
        try:
            return fn(*args, **kwargs)
        finally:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
    except ToldToLeaveError:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGTERM)  # so that others see how it ended
        raise


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """Let a worker that is told to leave end without more ado: the block begins nothing.

    Libraries in C++ that are loaded or called there say more than one line of an exception.
    """
    if signal.getsignal(signal.SIGTERM) is not _leave:
        yield
        return
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, _leave)


def _leave(*_: object) -> None:
    raise ToldToLeaveError
