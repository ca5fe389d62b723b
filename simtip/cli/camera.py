"""`simtip camera`: a scene's camera, measured by EMVA 1288."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from simtip.cli.errors import located
from simtip.cli.options import JsonOption, SceneArgument, SeedOption, named
from simtip.cli.output import print_json
from simtip.scene_file import read_scene


def camera(
    scene: SceneArgument,
    side: Annotated[
        Literal["left", "right"], typer.Option("--side", help="Which of the two cameras.")
    ] = "left",
    seed: SeedOption = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            parser=named,
            metavar="FILE",
            help="Write the photon-transfer plot, PNG or SVG.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Measure a scene's own camera by EMVA 1288: configured against recovered."""
    from simtip.bench_camera import measure_scene_camera
    from simtip.console import progress_bar, show_camera
    from simtip.output_folder import check_new_file, write_atomically
    from simtip.report.photon_transfer import plot_photon_transfer

    source = read_scene(scene)
    if plot is not None:
        check_new_file(plot, endings=(".png", ".svg"))
    with located(source), progress_bar("measuring") as progress:
        result = measure_scene_camera(source.spec, side, seed=seed, progress=progress)
    if plot is not None:
        write_atomically(plot, plot_photon_transfer(result.recovered, plot.suffix[1:].lower()))
    if as_json:
        print_json(result.to_dict())
        return
    show_camera(result.to_dict())
