"""What people see of a measurement capability analysis: tables on stdout."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from simtip.capability_rows import (
    GAUGE_ROWS,
    Row,
    accuracy_rows,
    agreement_rows,
    position_rows,
    remarks,
    repeatability_rows,
    tests_in_words,
    verdict_in_words,
)
from simtip.detect.excerpt import printable


def show_capability(result: dict[str, Any]) -> None:
    """Print what ``mca --json`` holds, as tables, with what was left out and why."""
    console = Console()
    _line(
        console,
        f"{result['file']}: {result['rows']} rows, {result['runs']} runs, "
        f"readings are {result['readings']}s; in the file's own unit",
    )
    _analyses(console, result)
    _remarks(console, result)


def show_experiment(result: dict[str, Any]) -> None:
    """Print what ``mca SCENE --json`` holds, likewise; lengths are in millimetres."""
    console = Console()
    seen = result["detection"]
    failed = "".join(f", {count} {name}" for name, count in seen["failed"].items())
    _line(
        console,
        f"{result['scene']}: {result['detector']}, {seen['measurements']} measurements, "
        f"{100 * seen['rate']:.4g} % with a tip{failed}; lengths in mm",
    )
    _analyses(console, result)
    title = f"position: measured - true, in the {result['position']['frame']}'s frame"
    _table(console, title, _percent(result), position_rows(result))
    frame = result["registration"]
    if frame is not None:
        error = frame["position_error_mm"]
        _line(
            console,
            f"registration of the stage's frame: FRE {_number(frame['fre_rms_mm'])} mm, turned by "
            f"{_number(frame['rotation_error_deg'])} degrees; tips in that frame are off by "
            f"{_number(error['rms'])} mm (RMS), {_number(error['max'])} mm at most",
        )
    _remarks(console, result)


def _percent(result: dict[str, Any]) -> str:
    return f"{100 * result['level']:g} % interval"


def _analyses(console: Console, result: dict[str, Any]) -> None:
    percent = _percent(result)
    if result["accuracy"] is not None:
        _table(
            console, "accuracy: measured - reference", percent, accuracy_rows(result["accuracy"])
        )
    if result["agreement"] is not None:
        agreement = result["agreement"]
        _table(console, "agreement", percent, agreement_rows(agreement))
        _line(console, agreement["method"])
        _line(console, tests_in_words(agreement))
    if result["repeatability"] is not None:
        repeatability = result["repeatability"]
        _table(console, "repeatability", percent, repeatability_rows(repeatability))
        for verdict in repeatability["verdicts"]:
            _line(console, verdict_in_words(verdict))
    if result["grr"] is not None:
        _gauge(console, result["grr"], percent)


def _gauge(console: Console, told: dict[str, Any], percent: str) -> None:
    table = Table(title="gauge R&R, analysis of variance")
    table.add_column("source")
    for heading in ("SD", percent, "% of TV", "% contribution", "% of tolerance"):
        table.add_column(heading, justify="right")
    for name, title in GAUGE_ROWS.items():
        tolerance = told["percent_tolerance"]
        table.add_row(
            title,
            _number(told[name]),
            _ends(told[f"{name}_ci"]),
            _number(told["percent_tv"][name], 4),
            _number(told["percent_contribution"][name], 4),
            "-" if tolerance is None else _number(tolerance[name], 4),
        )
    console.print(table)
    ranges = told["average_and_range"]
    _line(
        console,
        f"ndc {told['ndc'] or '-'}; GRR is {told['grr_percent_tv']:.4g} % of TV "
        f"({_ends(told['grr_percent_tv_ci'])}); by average and range: EV {_number(ranges['ev'])}, "
        f"AV {_number(ranges['av'])}, GRR {_number(ranges['grr'])}, PV {_number(ranges['pv'])}, "
        f"TV {_number(ranges['tv'])}, ndc {ranges['ndc'] or '-'}",
    )


def _remarks(console: Console, result: dict[str, Any]) -> None:
    for line in remarks(result):
        _line(console, line)


def _table(console: Console, title: str, percent: str, rows: list[Row]) -> None:
    table = Table(title=title)
    table.add_column("")
    table.add_column("value", justify="right")
    table.add_column(percent, justify="right")
    for name, value, interval in rows:
        table.add_row(Text(name), _number(value), _ends(interval))
    console.print(table)


def _line(console: Console, text: str) -> None:
    console.print(printable(text), markup=False, highlight=False, soft_wrap=True)


def _number(value: float | None, digits: int = 6) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


def _ends(interval: list[float | None] | None) -> str:
    return "-" if interval is None else " .. ".join(_number(end) for end in interval)
