"""`simtip report`: a page of any folder of results."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.options import BackendOption, named
from simtip.cli.output import say
from simtip.errors import InputError

NAME = "report.html"


def report(
    folder: Annotated[
        Path,
        typer.Argument(
            parser=named,
            metavar="DIR",
            help="Folder of run, render, boards, sweep, mca, budget or regress, or --plots of "
            "calibrate.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", parser=named, metavar="FILE", help="By default report.html in DIR."
        ),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(
            "--figures",
            parser=named,
            metavar="FOLDER",
            help="New or empty folder for all figures as SVG and PNG.",
        ),
    ] = None,
    pictures: Annotated[
        int,
        typer.Option(
            "--pictures", min=0, max=200, metavar="N", help="Worst trials of a sweep to show."
        ),
    ] = 10,
    limit: Annotated[
        float | None,
        typer.Option(
            "--limit", metavar="MM", help="Of the error, where a sweep's operating envelope ends."
        ),
    ] = None,
    bound: Annotated[
        Path | None,
        typer.Option(
            "--bound",
            parser=named,
            metavar="FILE",
            help="JSON of `simtip bound` of a sweep's scene, for efficiency.",
        ),
    ] = None,
    cache: Annotated[
        Path | None,
        typer.Option("--cache", parser=named, metavar="DIR", help="Of renders and images."),
    ] = None,
    backend: BackendOption = None,
) -> None:
    """Make one HTML file of a folder of results, which opens without network."""
    from simtip.bound_file import read_bound
    from simtip.console import progress_bar
    from simtip.output_folder import OutputFolder, result_folder, write_atomically
    from simtip.page.folder import results_in
    from simtip.page.html import html_of
    from simtip.page.make import page_of, write_figures
    from simtip.page.options import Options

    if limit is not None and not (math.isfinite(limit) and limit > 0):
        raise InputError(
            f"is {limit:g}", field="--limit", remedy="give millimetres above 0, as 0.5"
        )
    results = results_in(folder)
    file = folder / NAME if out is None else out
    _check_file(file)
    if figures is not None:
        OutputFolder(figures).check()
    known = None if bound is None else read_bound(bound)
    if known is not None and results.kind != "sweep":
        raise InputError("goes with a sweep only", field="--bound", remedy="leave it out")
    with progress_bar("pictures of the worst trials") as progress:
        page = page_of(results, Options(pictures, limit, known, cache, backend, progress))
    write_atomically(file, html_of(page).encode())
    say(f"written to {file}: the page")
    if figures is not None:
        with result_folder(figures) as made:
            names = write_figures(page, made)
        say(f"written to {figures}: {len(names)} files")


def _check_file(file: Path) -> None:
    """Refuse to replace a file that is no page of simtip's.

    Raises
    ------
    InputError
        It is something else, or has no folder.
    """
    from simtip.output_folder import check_new_file
    from simtip.page.html import is_page

    if is_page(file):
        return
    check_new_file(file, (".html", ".htm"))
