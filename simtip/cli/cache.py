"""`simtip cache`: what sweeps keep for the next one, and how to be rid of it."""

from __future__ import annotations

import datetime as dt
from pathlib import Path
from typing import Annotated, Any

import typer

from simtip.cli.options import JsonOption, named
from simtip.cli.output import print_json, say, to_stdout
from simtip.detect.excerpt import printable
from simtip.errors import InputError
from simtip.sweep.cache import (
    DEFAULT_LIMIT_BYTES,
    FOLDER_VARIABLE,
    Cache,
    default_folder,
)
from simtip.sweep.cache_items import Kind
from simtip.sweep.sizes import SIZE_OPTION, parse_size, shown_size

CacheOption = Annotated[
    Path | None,
    typer.Option(
        "--cache",
        parser=named,
        metavar="DIR",
        help=f"Folder of the cache; else that of {FOLDER_VARIABLE}, else this user's own.",
    ),
]

cache = typer.Typer()


@cache.callback(invoke_without_command=True)
def show(context: typer.Context, folder: CacheOption = None, as_json: JsonOption = False) -> None:
    """Show what the cache holds, by kind; the commands remove it."""
    if context.invoked_subcommand is not None:
        context.obj = (folder, as_json)
        return
    opened = _opened(folder)
    found = opened.summary()
    if as_json:
        print_json(_as_dict(opened.folder, found))
        return
    with to_stdout():
        _show(opened.folder, found)


@cache.command("clear")
def clear(
    context: typer.Context,
    kind: Annotated[
        str | None, typer.Option("--kind", metavar="NAME", help="Only this kind, such as light.")
    ] = None,
    folder: CacheOption = None,
    as_json: JsonOption = False,
) -> None:
    """Remove all of it, or all of one kind; what a running sweep needs is worked out again."""
    outer_folder, outer_json = context.obj
    opened = _opened(folder or outer_folder)
    try:
        freed = opened.clear(kind)
    except ValueError as error:
        raise InputError(
            f"{kind!r} is no kind", field="--kind", remedy="`simtip cache` shows which there are"
        ) from error
    _tell(opened, freed + opened.sweep_up(), as_json or outer_json)


@cache.command("trim")
def trim(
    context: typer.Context,
    size: Annotated[
        str, typer.Option(SIZE_OPTION, metavar="SIZE", help="What may stay, such as 5GB.")
    ],
    folder: CacheOption = None,
    as_json: JsonOption = False,
) -> None:
    """Remove what was not used for longest, until the rest fits into SIZE."""
    outer_folder, outer_json = context.obj
    limit_bytes = parse_size(size)
    opened = _opened(folder or outer_folder)
    freed = opened.sweep_up() + opened.trim(limit_bytes)
    _tell(opened, freed, as_json or outer_json)


def _opened(folder: Path | None) -> Cache:
    """Give the cache, without making its folder.

    Raises
    ------
    InputError
        There is something that is no folder, or it cannot be looked into.
    """
    opened = Cache(folder or default_folder())
    try:
        next(opened.folder.iterdir(), None)
    except FileNotFoundError:
        pass  # an empty one
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"cannot be used as a cache ({reason})",
            file=opened.folder,
            remedy="name another folder with --cache",
        ) from error
    return opened


def _as_dict(folder: Path, found: dict[str, Kind]) -> dict[str, Any]:
    return {
        "folder": str(folder),
        "limit_bytes": DEFAULT_LIMIT_BYTES,
        "bytes": _bytes(found),
        "kinds": {
            name: {
                "count": kind.count,
                "bytes": kind.bytes,
                "oldest_use_utc": _time(kind.oldest_s, dt.UTC).isoformat(timespec="seconds"),
                "newest_use_utc": _time(kind.newest_s, dt.UTC).isoformat(timespec="seconds"),
            }
            for name, kind in found.items()
        },
    }


def _show(folder: Path, found: dict[str, Kind]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    say(printable(str(folder)))
    if found:
        table = Table()
        table.add_column("kind", overflow="fold")
        for heading in ("entries", "size", "last used", "longest unused since"):
            table.add_column(heading, justify="right")
        for name, kind in found.items():
            used = (f"{_time(t):%Y-%m-%d %H:%M}" for t in (kind.newest_s, kind.oldest_s))
            table.add_row(name, str(kind.count), shown_size(kind.bytes), *used)
        console.print(table)
    limit = shown_size(DEFAULT_LIMIT_BYTES)
    say(f"{shown_size(_bytes(found))} in all; a sweep's limit is {limit} unless it is given one")


def _tell(opened: Cache, freed: int, as_json: bool) -> None:
    left = _bytes(opened.summary())
    if as_json:
        print_json({"folder": str(opened.folder), "freed_bytes": freed, "left_bytes": left})
        return
    say(f"{printable(str(opened.folder))}: {shown_size(freed)} freed, {shown_size(left)} left")


def _bytes(found: dict[str, Kind]) -> int:
    return sum(kind.bytes for kind in found.values())


def _time(seconds: float, zone: dt.tzinfo | None = None) -> dt.datetime:
    """Give a time of a file, s since 1970; files may have any, years that no calendar has too."""
    try:
        return dt.datetime.fromtimestamp(seconds, dt.UTC).astimezone(zone)
    except (ValueError, OverflowError, OSError):
        return dt.datetime.fromtimestamp(0, dt.UTC).astimezone(zone)
