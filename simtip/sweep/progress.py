"""How far a sweep is: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from simtip.sweep.tally import Report, Tally

PLAIN_EVERY_S = 10.0


@contextmanager
def progress(total: int) -> Iterator[Report]:
    """Show how far a sweep of so many trials is."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _plain()
        return
    columns = (
        TextColumn("sweep"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[said]}"),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("sweep", total=total, said="")

        def report(tally: Tally) -> None:
            bar.update(task, completed=tally.before + tally.done, said=said_of(tally))

        yield report


def _plain() -> Report:
    last = time.monotonic()

    def report(tally: Tally) -> None:
        nonlocal last
        if time.monotonic() - last >= PLAIN_EVERY_S:
            last = time.monotonic()
            sys.stderr.write(f"{tally.before + tally.done} of {tally.total}, {said_of(tally)}\n")

    return report


def said_of(tally: Tally) -> str:
    """Say rate, time to go, failures, renders, and what the cache spared."""
    if not tally.done:
        return f"{tally.counts.get('light', 0)} renders"
    rate = tally.done / max(tally.seconds, 1e-9)
    left = (tally.total - tally.before - tally.done) / rate
    spared = tally.done - tally.counts.get("measure", 0)
    said = [
        f"{rate:.1f} trials/s",
        f"{_duration(left)} to go",
        f"{sum(tally.failed.values())} without a tip",
        f"{tally.counts.get('light', 0)} renders",
        f"{max(spared, 0)} from the cache",
    ]
    return ", ".join(said)


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
