"""`simtip detect`: one detector on single images."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.detector_options import (
    DetectorOption,
    SettingsOption,
    as_detector_options,
    configured,
    parse_roi,
)
from simtip.cli.errors import as_option
from simtip.cli.options import named
from simtip.cli.output import say, say_where, to_stdout


def detect(
    images: Annotated[
        list[Path],
        typer.Argument(parser=named, metavar="IMAGE...", help="Image files of any origin."),
    ],
    detector: DetectorOption = "lin2020",
    settings: SettingsOption = None,
    roi: Annotated[
        str | None,
        typer.Option("--roi", metavar="X,Y,W,H", help="Look in this region only, px."),
    ] = None,
    overlay: Annotated[
        Path | None,
        typer.Option(
            "--overlay", parser=named, metavar="DIR", help="New or empty folder for pictures."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON list on stdout.")] = False,
) -> None:
    """Find the needle tip in single images; with --json a list, an item an image."""
    from simtip.console import progress_bar
    from simtip.detection import check_images, detections
    from simtip.detection_console import show_detections
    from simtip.detection_overlay import OverlayWriter
    from simtip.output_folder import OutputFolder, result_folder

    region = parse_roi(roi, "--roi")
    chosen = configured(detector, settings)
    if overlay is not None:
        OutputFolder(overlay).check()
    shapes = check_images(images)
    if region is not None:
        with as_option("--roi"):
            for file, shape in zip(images, shapes, strict=True):
                region.check(shape, file=file)
    found = []
    with (
        as_detector_options(),
        nullcontext() if overlay is None else result_folder(overlay) as folder,
        progress_bar("detecting") as progress,
    ):
        writer = None if folder is None else OverlayWriter(folder)
        for seen in detections(
            images, chosen, region=region, layers=overlay is not None, report=progress
        ):
            found.append(seen.to_dict())
            if writer is not None:
                writer.write(seen)
    if as_json:
        say(json.dumps(found, allow_nan=False))
        return
    with to_stdout():
        show_detections(found)
    say_where(overlay, "pictures")
