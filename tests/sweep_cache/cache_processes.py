"""A cache with small entries, and processes that use it at the same time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from simtip.sweep.cache import Cache

BLOCK = 4096
KEYS = [f"{k:016x}" for k in range(16)]

PRELUDE = """
import os, random, sys, time
from pathlib import Path
from simtip.sweep.cache import Cache
folder = Path(sys.argv[1])
cache = Cache(folder)
"""


def start(code: str, folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Run code in a process of its own, where `cache` is the one in that folder."""
    return subprocess.Popen(
        [sys.executable, "-c", PRELUDE + code, str(folder), *arguments],
        stdout=subprocess.PIPE,
        text=True,
    )


def run(code: str, folder: Path, *arguments: str) -> str:
    """Run code like that to its end, and give what it printed."""
    return ended(start(code, folder, *arguments))


def ended(process: subprocess.Popen[str]) -> str:
    """Wait until a process has ended well, and give what it printed."""
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    return out


def kill(process: subprocess.Popen[str]) -> None:
    """End it without any chance to clean up."""
    process.kill()
    process.communicate()


def blocks(n: int):
    """Give a function that writes an entry of n blocks in all."""

    def write(folder: Path) -> None:
        (folder / "data").write_bytes(b"x" * BLOCK * (n - 1))

    return write


def kept(cache: Cache, kind: str = "light") -> list[int]:
    """Give the places in `KEYS` of the entries that there are, without using them."""
    folder = cache.folder / "v1" / kind
    return [i for i, key in enumerate(KEYS) if (folder / key[:2] / key).is_dir()]


def leftovers(cache: Cache) -> list[str]:
    """Give the names in the folder for unfinished things."""
    folder = cache.folder / "v1" / "tmp"
    return sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []
