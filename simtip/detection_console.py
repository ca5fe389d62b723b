"""What people see of detectors and of single detections: tables on stdout."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from simtip.detect.excerpt import printable


def show_detections(found: Sequence[dict[str, Any]]) -> None:
    """Print the items of ``detect --json`` as a table, and the reasons of failures below."""
    console = Console()
    table = Table(title="tip, px of the whole image")
    table.add_column("image", overflow="fold")
    table.add_column("status", overflow="fold")
    for heading in ("u", "v", "axis, deg", "sd u, v", "confidence", "ms"):
        table.add_column(heading, justify="right")
    for item in found:
        u, v = item["tip_px"] or (None, None)
        table.add_row(
            Text(printable(item["image"])),
            item["status"],
            _number(u),
            _number(v),
            _angle(item["axis"]),
            _deviations(item["covariance_px"]),
            _number(item["confidence"]),
            f"{1000 * item['time_s']:.0f}",
        )
    console.print(table)
    for item in found:
        if item["reason"]:
            line = f"{printable(item['image'])}: {item['reason']}"
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def show_detectors(detectors: Sequence[dict[str, Any]]) -> None:
    """Print the items of ``detectors --json``: each detector, and what can be set on it."""
    console = Console()
    for item in detectors:
        title = f"{printable(item['name'])}: {printable(item['summary'])}".removesuffix(": ")
        console.print(Text(title, style="bold"), soft_wrap=True)
        console.print(Text(f"  {printable(item['source'])}"), soft_wrap=True)
        if item["fault"]:
            console.print(Text(f"  cannot be used: {printable(item['fault'])}"), soft_wrap=True)
        if item["parameters"]:
            console.print(_parameters(item["parameters"]))


def _parameters(parameters: Sequence[dict[str, Any]]) -> Table:
    table = Table()
    table.add_column("parameter", overflow="fold")
    table.add_column("type", overflow="fold")
    table.add_column("default", overflow="fold")
    table.add_column("what", overflow="fold")
    for item in parameters:
        default = "required" if item["required"] else _text(item["default"])
        cells = (item["name"], item["type"], default, item["description"])
        table.add_row(*(Text(printable(cell)) for cell in cells))
    return table


def _text(value: object) -> str:
    if isinstance(value, list):
        return ",".join(map(str, value))
    return "none" if value is None else str(value)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _angle(axis: list[float] | None) -> str:
    """Direction from the tip to the hub, from right over down, degrees."""
    return "-" if axis is None else f"{math.degrees(math.atan2(axis[1], axis[0])):.1f}"


def _deviations(covariance: list[list[float]] | None) -> str:
    if covariance is None:
        return "-"
    return ", ".join(f"{math.sqrt(max(0, covariance[k][k])):.3f}" for k in range(2))
