"""`simtip mca`: measurement capability analysis of measurements in a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import typer

from simtip.cli.options import JsonOption, named
from simtip.cli.output import print_json
from simtip.errors import InputError


def mca(
    csv: Annotated[
        Path,
        typer.Option(
            "--csv",
            parser=named,
            metavar="FILE",
            help="Measurements: a header, then a row each. Columns: measured; reference for "
            "accuracy and agreement; part for repeatability; operator for gauge R&R; trial; run.",
        ),
    ],
    tolerance: Annotated[
        float | None,
        typer.Option("--tolerance", metavar="T", help="USL - LSL, in the unit of the file."),
    ] = None,
    multiplier: Annotated[
        float, typer.Option("--multiplier", metavar="K", help="Of P/T: 6, or 5.15 as of old.")
    ] = 6.0,
    level: Annotated[
        float, typer.Option("--level", metavar="P", help="Confidence level of all intervals.")
    ] = 0.95,
    readings: Annotated[
        Literal["displacement", "position", "step"],
        typer.Option(
            "--readings",
            help="What a row holds: displacement from the run's start, position, or step.",
        ),
    ] = "displacement",
    repeated: Annotated[
        Literal["varies", "constant"] | None,
        typer.Option(
            "--repeated",
            help="Limits of agreement for several pairs per part: its true value varies or is "
            "constant. By default every pair counts as independent.",
        ),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option(
            "--column",
            metavar="NAME=HEADER",
            help="The file's own header of a column, e.g. reference=xl80; repeatable.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Analyse accuracy, agreement, repeatability and gauge R&R of measurements, with intervals."""
    from simtip.capability.report import Settings, report_on
    from simtip.capability.table import read_table
    from simtip.console_capability import show_capability

    _check(level, tolerance, multiplier)
    table = read_table(csv, _columns(columns or []))
    settings = Settings(readings, repeated, tolerance, multiplier, level)
    result = report_on(table, settings).to_dict()
    if as_json:
        print_json(result)
        return
    show_capability(result)


def _check(level: float, tolerance: float | None, multiplier: float) -> None:
    if not 0.5 <= level <= 0.9999:
        raise InputError(
            f"is {level:g}, and not between 0.5 and 0.9999",
            field="--level",
            remedy="0.95 is 95 %",
        )
    for option, number in (("--tolerance", tolerance), ("--multiplier", multiplier)):
        if number is not None and not (math.isfinite(number) and 1e-30 <= number <= 1e30):
            raise InputError(
                f"is {number:g}", field=option, remedy="give a number above 0, as 0.62"
            )


def _columns(texts: list[str]) -> dict[str, str]:
    from simtip.capability.table import COLUMNS

    found: dict[str, str] = {}
    for text in texts:
        name, sign, header = (part.strip() for part in text.partition("="))
        if not sign or not header or name not in COLUMNS:
            raise InputError(
                f"{text[:80]!r} is not NAME=HEADER",
                field="--column",
                remedy=f"NAME is one of {', '.join(COLUMNS)}",
            )
        if name in found:
            raise InputError(
                f"{name} is there twice", field="--column", remedy="name one header for it"
            )
        found[name] = header
    return found
