"""`simtip remix`: new images from rendered light."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.errors import located
from simtip.cli.options import JsonOption, SeedOption, named
from simtip.cli.output import print_json, say_where
from simtip.scene_file import read_scene


def remix(
    lights: Annotated[
        Path,
        typer.Argument(
            parser=named, metavar="DIR", help="Folder that `simtip render --lights` wrote."
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", parser=named, metavar="DIR", help="New or empty folder for results."
        ),
    ],
    scene: Annotated[
        Path | None,
        typer.Argument(
            parser=named,
            metavar="SCENE",
            help="The scene with other lamp powers, colours, exposure or sensor.",
        ),
    ] = None,
    seed: SeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make new images from rendered light, without rendering again."""
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.remix import remix as mixed
    from simtip.result_folder import write_manifest, write_simulation

    source = None if scene is None else read_scene(scene)
    OutputFolder(out).check()
    with nullcontext() if source is None else located(source):
        done = mixed(lights, None if source is None else source.spec, seed=seed)
    with result_folder(out) as folder:
        write_simulation(folder, done)
        write_manifest(folder, done, done.timings_s)
    if as_json:
        facts = {"scene": done.spec.name, "seed": done.seed, "lights": str(lights)}
        truth = done.truth.to_dict()
        print_json({**facts, "out": str(out), "truth": truth, "timings_s": done.timings_s})
        return
    say_where(out, "left.png, right.png, truth.json")
