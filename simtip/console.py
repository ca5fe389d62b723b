"""What people see on the terminal: tables on stdout, progress and errors on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from simtip.doctor import Diagnosis
from simtip.render import Progress as Report

PLAIN_EVERY_S = 10.0


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """Show a bar on a terminal; elsewhere a plain line now and then."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _plain(title)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
    )
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda done: bar.update(task, completed=done)


def _plain(title: str) -> Report:
    last = time.monotonic()

    def report(done: float) -> None:
        nonlocal last
        if time.monotonic() - last >= PLAIN_EVERY_S:
            last = time.monotonic()
            sys.stderr.write(f"{title} {done:.0%}\n")

    return report


def show_result(result: dict[str, Any]) -> None:
    """Print a trial or a measurement as tables."""
    console = Console()
    if result["status"] != "ok":
        console.print(
            f"no tip: {result['reason']} ({result['status']})", style="bold", markup=False
        )
    console.print(_space_table(result))
    console.print(_pixel_table(result))
    seconds = ", ".join(f"{name} {value:.2f} s" for name, value in result["timings_s"].items())
    lines = [_details(result), *_efficiency(result.get("efficiency")), seconds]
    console.print("\n".join(lines), markup=False, highlight=False)


def _space_table(result: dict[str, Any]) -> Table:
    scored = "tip_true_mm" in result
    table = Table(title="tip, mm, left camera frame")
    table.add_column("axis")
    for heading in ("measured", "true", "error") if scored else ("measured",):
        table.add_column(heading, justify="right")
    error = result.get("error_mm") or {}
    for k, axis in enumerate("xyz"):
        cells = [_number(result["tip_measured_mm"], k)]
        if scored:
            cells += [_number(result["tip_true_mm"], k), _signed(error.get(axis))]
        table.add_row(axis, *cells)
    if scored:
        norm = error.get("norm")
        table.add_row("norm", "", "", "-" if norm is None else f"{norm:.4f}", style="bold")
    return table


def _pixel_table(result: dict[str, Any]) -> Table:
    scored = "tip_true_px" in result
    table = Table(title="tip, px")
    for heading in ("view", "detected u, v"):
        table.add_column(heading)
    for heading in ("true u, v", "along", "across") if scored else ():
        table.add_column(heading, justify="right")
    for side in ("left", "right"):
        cells = [_pair(result["tip_detected_px"][side])]
        if scored:
            error = result["error_px"][side] or {}
            cells += [
                _pair(result["tip_true_px"][side]),
                _signed(error.get("along"), 2),
                _signed(error.get("across"), 2),
            ]
        table.add_row(side, *cells)
    return table


def _details(result: dict[str, Any]) -> str:
    distance = result["epipolar_distance_px"]
    refined = result.get("refined")
    parts = [
        f"detector {result['detector']}",
        "" if refined is None else f"refined: {refined['reason'] or refined['status']}",
        "" if distance is None else f"epipolar distance {distance:.3f} px",
        f"back end {result['backend']}" if "backend" in result else "",
        f"seed {result['seed']}" if "seed" in result else "",
    ]
    return ", ".join(part for part in parts if part)


def _efficiency(told: dict[str, float | None] | None) -> list[str]:
    """Give the line about efficiency, if a bound is known."""
    if told is None:
        return []
    bound_mm = told["bound_mm"]
    if bound_mm is None:
        return ["bound: the images do not determine the tip"]
    ratios = [
        f"{name} {value:.3g}"
        for name, value in told.items()
        if name != "bound_mm" and value is not None
    ]
    return [f"bound {bound_mm:.3g} mm, efficiency: {', '.join(ratios) or 'nothing was measured'}"]


def _number(vector: list[float] | None, k: int) -> str:
    return "-" if vector is None else f"{vector[k]:.4f}"


def _signed(value: float | None, digits: int = 4) -> str:
    return "-" if value is None else f"{value:+.{digits}f}"


def _pair(pixel: list[float] | None) -> str:
    return "-" if pixel is None else f"{pixel[0]:.2f}, {pixel[1]:.2f}"


def show_camera(result: dict[str, Any]) -> None:
    """Print what a camera was configured to and what was recovered from its frames."""
    console = Console()
    table = Table(title="EMVA 1288, green channel")
    for heading in ("parameter", "configured", "recovered", "99 % interval"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name, value in result["configured"].items():
        found, interval = result["recovered"][name], result["ci99"][name]
        ends = "-" if interval is None else " .. ".join(f"{end:.5g}" for end in interval)
        table.add_row(name, f"{value:.5g}", "-" if found is None else f"{found:.5g}", ends)
    console.print(table)
    for name, reason in result["reasons"].items():
        console.print(f"{name}: {reason}", markup=False, highlight=False)
    for note in result["notes"]:
        console.print(f"note: {note}", markup=False, highlight=False)


def show_diagnosis(diagnosis: Diagnosis, versions: dict[str, Any]) -> None:
    """Print what was found, what is used and why, and how to mend what is missing."""
    console = Console()
    table = Table(title="renderer back ends")
    table.add_column("what", overflow="fold")
    table.add_column("works")
    table.add_column("detail", overflow="fold")
    table.add_row("GPU (CUDA)", _yes(diagnosis.cuda.ok), Text(diagnosis.cuda.detail))
    for candidate, verdict in diagnosis.llvm:
        table.add_row(Text(f"LLVM: {candidate.path}"), _yes(verdict.ok), Text(verdict.detail))
    if not diagnosis.llvm:
        table.add_row("LLVM", "no", "no library found")
    table.add_row("scalar", "yes", "always there, some 20 times slower")
    console.print(table)
    packages = ", ".join(f"{k} {v}" for k, v in versions["packages"].items() if v)
    used = "none: " + diagnosis.problem
    if diagnosis.backend is not None:
        used = f"{diagnosis.backend.variant} ({diagnosis.backend.reason})"
    lines = [
        f"simtip {versions['simtip']}, Python {versions['python']}, {versions['platform']}",
        packages,
        f"used: {used}",
        f"trial: {diagnosis.trial.detail}",
        *(f"to mend: {step}" for step in diagnosis.advice),
    ]
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _yes(works: bool) -> str:
    return "yes" if works else "no"
