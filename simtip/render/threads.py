"""How many threads Dr.Jit may use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def limited_threads(count: int | None) -> Iterator[None]:
    """Let the renderer use so many threads within the block; None leaves it as it is."""
    if count is None:
        yield
        return
    from simtip.render.engine import dr

    before = dr.thread_count()
    dr.set_thread_count(count)
    try:
        yield
    finally:
        dr.set_thread_count(before)
