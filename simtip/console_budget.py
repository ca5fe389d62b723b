"""What people see of an error budget: tables on stdout."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

KINDS = {
    "position": "absolute position",
    "step": "displacement, from one position to the next",
    "from_start": "displacement, from the run's start",
}


def show_budget(result: dict[str, Any]) -> None:
    """Print what ``budget --json`` holds, as tables, with what the causes are."""
    console = Console()
    _line(
        console,
        f"{result['scene']}: {result['detector']}, {result['positions']} positions, "
        f"{result['replicates']} replicates; the tip is seen "
        f"{result['recession_mm']['mean']:.4g} mm short "
        f"({result['recession_mm']['min']:.4g} .. {result['recession_mm']['max']:.4g})",
    )
    for kind, title in KINDS.items():
        if result[kind] is None:
            _line(console, f"{title}: left out, for too few were seen in every state")
        else:
            _kind(console, title, result[kind], result["level"])
    for cause, without in result["causes"].items():
        _line(console, f"without {cause}: {without}")
    for cause, why in result["absent"].items():
        _line(console, f"{cause} is no cause here: {why}")
    if result["refused_by_matching"]:
        share = f"{100 * result['refused_by_matching']:.3g} %"
        _line(
            console,
            f"note: matching would refuse {share} of these measurements, which count here "
            "(match.max_distance_px)",
        )
    if result["positions_left_out"]:
        _line(console, f"note: {result['positions_left_out']} positions are left out: unseen")


def _kind(console: Console, title: str, told: dict[str, Any], level: float) -> None:
    table = Table(title=f"{title}: RMS error {told['rms_mm']:.4g} mm")
    table.add_column("cause")
    for heading in (
        "share, %",
        "share, um2",
        f"{100 * level:g} % interval",
        "alone, um",
        "RMS without, mm",
    ):
        table.add_column(heading, justify="right")
    for row in told["shares"]:
        table.add_row(
            Text(row["cause"]),
            "-" if row["percent"] is None else f"{row['percent']:.1f}",
            _squares(row["shapley_mm2"]),
            " .. ".join(map(_squares, row["shapley_ci_mm2"])),
            _root(row["alone_mm2"]),
            f"{row['rms_without_mm']:.4g}",
        )
    console.print(table)
    _line(
        console,
        f"shares add up to {_squares(told['sum_of_shares_mm2'])} um2, and the rest without any "
        f"cause is {_squares(told['rest_mm2'])}: together the mean square error, "
        f"{_squares(told['total_mm2'])} um2",
    )


def _squares(mm2: float) -> str:
    return f"{mm2 * 1e6:.4g}"


def _root(mm2: float) -> str:
    """Give the root mean square that a mean square is, um; with its sign."""
    return f"{math.copysign(math.sqrt(abs(mm2)), mm2) * 1e3:.4g}"


def _line(console: Console, text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)
