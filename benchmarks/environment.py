"""What every benchmark shares: arguments, the environment it ran in, how time is taken, output."""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import sys
import time
from dataclasses import dataclass
from importlib import metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

PACKAGES = ("simtip", "numpy", "scipy", "opencv-python-headless", "mitsuba", "drjit")


def environment() -> dict[str, Any]:
    """Say where and with what the benchmark ran, for the head of its JSON."""
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = None
    return {
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "cpu_count": os.cpu_count(),
        "cpu_usable": usable_cpus(),
        "load_average": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
        "versions": versions,
    }


def usable_cpus() -> int | None:
    """Give how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count()


def parser(doc: str) -> argparse.ArgumentParser:
    """Make a benchmark's argument parser; single benchmarks may add to it."""
    made = argparse.ArgumentParser(description=doc.splitlines()[0])
    made.add_argument("--quick", action="store_true", help="small and once: a smoke run")
    made.add_argument(
        "--json", action="store_true", help="print one JSON object, as is always done"
    )
    return made


def report(name: str, *, quick: bool, **figures: Any) -> None:
    """Print one JSON object: the benchmark, its environment and its figures."""
    head = {"benchmark": name, "environment": environment(), "quick": quick}
    print(json.dumps({**head, **figures}, indent=2, allow_nan=False))


def best_s(work: Callable[[], object], repeats: int) -> float:
    """Run something several times and give the shortest wall time, s: the one least disturbed."""
    return min(spent(work).wall_s for _ in range(repeats))


def each_s(work: Callable[[], object], repeats: int, at_least_s: float = 0.02) -> float:
    """Give the shortest wall time, s, of one call of something short, run many times in a row."""
    once = best_s(work, 3)
    calls = max(1, math.ceil(at_least_s / max(once, 1e-7)))

    def many() -> None:
        for _ in range(calls):
            work()

    return best_s(many, repeats) / calls


@dataclass(frozen=True)
class Spent:
    """Wall and CPU time, s; CPU time is that of all threads of this process."""

    wall_s: float
    cpu_s: float

    def best(self, other: Spent) -> Spent:
        """Take the less disturbed of each."""
        return Spent(min(self.wall_s, other.wall_s), min(self.cpu_s, other.cpu_s))


def spent(work: Callable[[], object]) -> Spent:
    """Run something once and say what it took."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return Spent(time.perf_counter() - wall, time.process_time() - cpu)
