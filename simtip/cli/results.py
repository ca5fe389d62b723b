"""`simtip results`: what a sweep has found so far, as tables, CSV or JSON."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from simtip.cli.options import named
from simtip.cli.output import say, to_stdout
from simtip.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from rich.table import Table as RichTable

    from simtip.sweep.table import Table

DEFAULT_STATS = "detection_rate,error_norm_mm:mean"
FIRST_ROWS = 10
"""So many trials are shown if nobody says how many."""

FEW = 6
"""So many different values of a factor are listed one by one."""


def results(
    folder: Annotated[Path, typer.Argument(parser=named, metavar="DIR", help="Folder of a sweep.")],
    by: Annotated[
        str | None,
        typer.Option("--by", metavar="COLUMNS", help="Group by these, e.g. sensor.gain,detector."),
    ] = None,
    stat: Annotated[
        str | None,
        typer.Option(
            "--stat",
            metavar="STATS",
            help="Of each group: detection_rate, count or COLUMN:HOW, with HOW mean, std, rms, "
            f"median, min, max, p05, p95, mean_abs or count; by default {DEFAULT_STATS}.",
        ),
    ] = None,
    where: Annotated[
        list[str] | None,
        typer.Option("--where", metavar="CONDITION", help="e.g. 'repeat<5'; repeatable."),
    ] = None,
    csv: Annotated[
        str | None,
        typer.Option("--csv", metavar="FILE", help="Write all of it to a new file; - is stdout."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="A list of records on stdout.")] = False,
    sort: Annotated[
        str | None, typer.Option("--sort", metavar="COLUMN", help="Smallest first.")
    ] = None,
    limit: Annotated[
        int | None, typer.Option("--limit", min=0, metavar="N", help="So many rows at most.")
    ] = None,
) -> None:
    """Show what a sweep has found, also while it is running."""
    from simtip.sweep.conditions import filtered
    from simtip.sweep.csv_text import to_csv
    from simtip.sweep.table import Table

    _check_outputs(csv, as_json)
    table = Table.open(folder)
    known = table.frame()
    chosen = filtered(known, where or [])
    groups = by is not None or stat is not None
    rows = _cut(_sorted(_groups(chosen, by, stat) if groups else chosen, sort), limit)
    if as_json:
        say(json.dumps(_records(rows), allow_nan=False))
    elif csv is not None:
        _write_csv(csv, to_csv(rows), len(rows))
    else:
        with to_stdout():
            if groups:
                _show(_rows_table("groups", rows))
            else:
                first = rows if limit is not None else rows.head(FIRST_ROWS)
                _show_progress(table, len(known), len(chosen))
                _show_overview(table, chosen, first)


def _check_outputs(csv: str | None, as_json: bool) -> None:
    from simtip.output_folder import check_new_file

    if csv is None:
        return
    if as_json:
        raise InputError("cannot be given with --csv", field="--json", remedy="give one of them")
    if csv != "-":
        check_new_file(Path(csv), (".csv",))


def _groups(chosen: pd.DataFrame, by: str | None, stat: str | None) -> pd.DataFrame:
    from simtip.sweep.summary import grouped

    stats = _names(DEFAULT_STATS if stat is None else stat, "--stat")
    return grouped(chosen, [] if by is None else _names(by, "--by"), stats)


def _names(text: str, option: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise InputError(
            f"{text[:200]!r} lacks a name", field=option, remedy="give names with commas between"
        )
    return names


def _sorted(rows: pd.DataFrame, column: str | None) -> pd.DataFrame:
    from simtip.sweep.frames import nearest

    if column is None:
        return rows
    if column not in rows.columns:
        raise InputError(
            f"there is no column {column[:200]!r}",
            field="--sort",
            remedy=nearest(column, map(str, rows.columns)),
        )
    return rows.sort_values(column, kind="stable", ignore_index=True)


def _cut(rows: pd.DataFrame, limit: int | None) -> pd.DataFrame:
    return rows if limit is None else rows.head(limit)


def _records(rows: pd.DataFrame) -> list[dict[str, Any]]:
    """Give the rows for JSON, which has neither NaN nor infinity."""
    from simtip.sweep.frames import plain

    names = [str(name) for name in rows.columns]
    columns = [[_finite(value) for value in plain(rows[name])] for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _write_csv(csv: str, text: str, count: int) -> None:
    from simtip.detect.excerpt import printable
    from simtip.output_folder import write_atomically

    if csv == "-":
        with to_stdout():
            sys.stdout.write(text)
        return
    write_atomically(csv, text.encode())
    say(f"written to {printable(csv)}: {count} rows")


# Tables for people


def _show(*tables: RichTable) -> None:
    from rich.console import Console

    console = Console()
    for table in tables:
        console.print(table)


def _show_progress(table: Table, known: int, chosen: int) -> None:
    from rich.console import Console

    from simtip.detect.excerpt import printable

    planned = table.provenance.get("trials")
    of = f" of {planned}" if isinstance(planned, int) else ""
    picked = "" if chosen == known else f", {chosen} of them chosen"
    line = f"{printable(str(table.folder))}: {known}{of} trials known{picked}"
    Console().print(line, markup=False, highlight=False, soft_wrap=True)


def _show_overview(table: Table, chosen: pd.DataFrame, first: pd.DataFrame) -> None:
    """Print how the trials ended, how well each detector does, what varies, and some trials."""
    if not len(chosen):
        return
    varying = _varying(table, chosen)
    _show(_status_table(chosen), _detector_table(chosen))
    if varying:
        _show(_varying_table(chosen, varying))
    if len(first):
        reasons = (
            ["reason"] if "reason" in first and first["reason"].fillna("").ne("").any() else []
        )
        columns = ["trial", *varying, "status", "error_norm_mm", *reasons]
        shown = first[[name for name in columns if name in first]]
        _show(_rows_table(f"{len(first)} of {len(chosen)} trials", shown))


def _varying(table: Table, chosen: pd.DataFrame) -> list[str]:
    """Give the factors, and such as a factor, that have more than one value."""
    from simtip.sweep.columns import FIXED

    fixed = {column.name for column in FIXED} - {"repeat", "detector"}
    names = [column.name for column in table.columns if column.name not in fixed]
    return [name for name in names if name in chosen and len(chosen[name].drop_duplicates()) > 1]


def _status_table(chosen: pd.DataFrame) -> RichTable:
    from simtip.sweep.summary import grouped

    counts = grouped(chosen, ["status"], []).rename(columns={"n": "trials"})
    return _rows_table("status", counts)


def _detector_table(chosen: pd.DataFrame) -> RichTable:
    from simtip.sweep.summary import grouped

    stats = ("detection_rate", "error_norm_mm:mean", "refined_norm_mm:mean")
    there = [stat for stat in stats if stat.partition(":")[0] in {"detection_rate", *chosen}]
    by = ["detector"] if "detector" in chosen else []
    return _rows_table("detectors", grouped(chosen, by, there))


def _varying_table(chosen: pd.DataFrame, names: Iterable[str]) -> RichTable:
    table = _empty_table("what varies", ["column", "values", "which"])
    for name in names:
        column = chosen[name]
        cells = (name, len(column.drop_duplicates()), _which(column))
        table.add_row(*map(_cell, cells))
    return table


def _which(column: pd.Series[Any]) -> str:
    """List a column's values if they are few, else the ends of their range."""
    from simtip.sweep.frames import kind_of, plain

    values = plain(column.drop_duplicates().sort_values())
    told = [_words(value) for value in _readable(column.name, values)]
    if len(told) <= FEW:
        return ", ".join(told)
    if kind_of(column) == "text":
        return ", ".join([*told[:FEW], "..."])
    present = [word for word, value in zip(told, values, strict=True) if value is not None]
    return f"{present[0]} .. {present[-1]}"


def _rows_table(title: str, rows: pd.DataFrame) -> RichTable:
    from simtip.sweep.frames import kind_of, plain

    names = [str(name) for name in rows.columns]
    table = _empty_table(title, names, [kind_of(rows[name]) != "text" for name in names])
    columns = [_readable(name, plain(rows[name])) for name in names]
    for row in zip(*columns, strict=True):
        table.add_row(*map(_cell, row))
    return table


def _readable(name: object, values: list[Any]) -> list[Any]:
    """Give a column's values with parts and lists, which factors may have, in few words."""
    from simtip.sweep.columns import FIXED
    from simtip.sweep.compact import compact

    if name in {column.name for column in FIXED}:
        return values
    return [compact(value) if isinstance(value, str) else value for value in values]


def _empty_table(
    title: str, names: Sequence[str], numbers: Sequence[bool] | None = None
) -> RichTable:
    from rich.table import Table as RichTable

    table = RichTable(title=title)
    for k, name in enumerate(names):
        right = numbers is not None and numbers[k]
        table.add_column(_cell(name), justify="right" if right else "left", overflow="fold")
    return table


def _cell(value: object) -> Any:
    """Give plain text that neither the terminal nor rich takes for anything else."""
    from rich.text import Text

    return Text(_words(value))


def _words(value: object) -> str:
    from simtip.detect.excerpt import printable

    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))
