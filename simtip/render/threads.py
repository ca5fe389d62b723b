"""How many threads Dr.Jit may use."""

from __future__ import annotations


def limit_threads(count: int) -> None:
    """Let the renderer of this process use so many threads from now on."""
    from simtip.render.engine import dr

    dr.set_thread_count(count)
