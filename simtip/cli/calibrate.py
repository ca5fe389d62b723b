"""`simtip calibrate`: a rig from images of a target."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.errors import as_option
from simtip.cli.options import JsonOption, named
from simtip.cli.output import print_json, say_where, to_stdout
from simtip.cli.rig_output import require_new
from simtip.errors import InputError
from simtip.rig_file import Format


def calibrate(
    images: Annotated[
        list[str],
        typer.Argument(
            metavar="DIR | LEFT RIGHT",
            help="Folder with left*, right* images, or a quoted pattern for each camera.",
        ),
    ],
    target: Annotated[
        str,
        typer.Option("--target", metavar="TARGET", help="E.g. chessboard:11x8:6 (inner corners)."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", parser=named, metavar="FILE", help="New file for the rig."),
    ] = None,
    form: Annotated[
        Format | None,
        typer.Option("--format", help="Of that file; by default what its ending says."),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            "--model", metavar="NAME", help="none, radial2, radtan, opencv5, rational, auto."
        ),
    ] = "opencv5",
    truth: Annotated[
        Path | None,
        typer.Option(
            "--truth",
            parser=named,
            metavar="FILE",
            help="truth.json of `simtip boards`: errors, too.",
        ),
    ] = None,
    plots: Annotated[
        Path | None,
        typer.Option(
            "--plots",
            parser=named,
            metavar="DIR",
            help="New or empty folder for pictures and numbers, of which `simtip report` makes a "
            "page.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Calibrate a stereo rig from images of a target, simtip's or any."""
    from simtip.calibrate.lens_model import lens_model
    from simtip.calibration_console import show_calibration
    from simtip.calibration_images import calibrate_images, read_board_truth
    from simtip.console import progress_bar
    from simtip.output_folder import OutputFolder
    from simtip.rig_file import write_rig
    from simtip.target import parse_target

    with as_option("--target"):
        wanted = parse_target(target)
    with as_option("--model"):
        lens_model(model)
    if out is not None:
        require_new(out, form)
    elif form is not None:
        raise InputError(
            "says the form of a file, and none is asked for",
            field="--format",
            remedy="name it by -o",
        )
    if plots is not None:
        OutputFolder(plots).check()
    known = None if truth is None else read_board_truth(truth)
    with progress_bar("finding the target") as progress:
        outcome = calibrate_images(images, wanted, model=model, truth=known, report=progress)
    result = outcome.to_dict()
    if plots is not None:
        from simtip.calibration_images.record import Record, write_record
        from simtip.report.calibration import calibration_figures
        from simtip.report.style import png

        with OutputFolder(plots) as folder:
            for name, figure in calibration_figures(Record.of(outcome)).items():
                (folder / f"{name}.png").write_bytes(png(figure))
            write_record(folder, outcome)
    if out is not None:
        write_rig(out, outcome.calibration.rig, form)
    if as_json:
        print_json(result)
        return
    with to_stdout():
        show_calibration(result)
    say_where(out, "the rig")
    say_where(plots, "pictures, calibration.json, points.json")
