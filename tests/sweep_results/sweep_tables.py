"""Tables of results, small enough for a test, and processes that write them."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

from simtip.sweep.columns import Column, columns_for
from simtip.sweep.table import Table

FACTORS = (
    Column("lamps[0].power", "float"),
    Column("needle.tip.kind", "text"),
    Column("detect.threshold", "int"),
    Column("match.strict", "bool"),
)
COLUMNS = columns_for(FACTORS)
PROVENANCE = {"trials": 40, "simtip": "0.1.0", "sweep": {"name": "Prüfung"}}


def row(k: int, **more) -> dict[str, object]:
    """Give the row of trial `k`; factors are given by their names with ``__`` for a dot."""
    given = {name.replace("__", "."): value for name, value in more.items()}
    return {"key": hashlib.sha256(b"%d" % k).hexdigest(), "trial": k, "status": "ok", **given}


def make(folder: Path, rows: list[dict[str, object]] | None = None) -> Table:
    table = Table.create(folder, COLUMNS, PROVENANCE)
    table.append(rows or [])
    return table


def parts(folder: Path) -> list[Path]:
    return sorted(folder.glob("rows*/part-*.parquet"))


def left_over(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.name.startswith(".")]


def started(code: str, *arguments: object) -> subprocess.Popen[str]:
    """Start Python on that code, with pipes to talk to it."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
