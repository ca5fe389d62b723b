"""`simtip render`: images and truth alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.errors import located
from simtip.cli.options import BackendOption, JsonOption, SceneArgument, SeedOption, named
from simtip.cli.output import print_json, say_where
from simtip.scene_file import read_scene


def render(
    scene: SceneArgument,
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", parser=named, metavar="DIR", help="New or empty folder for results."
        ),
    ],
    seed: SeedOption = None,
    backend: BackendOption = None,
    exr: Annotated[
        bool, typer.Option("--exr", help="Also float radiance, needle coverage and depth.")
    ] = False,
    lights: Annotated[
        bool, typer.Option("--lights", help="Also every lamp's light, for `simtip remix`.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Render a scene's images and write its truth, without measuring."""
    from simtip.console import progress_bar
    from simtip.measuring_rig import measuring_rig
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose
    from simtip.result_folder import write_manifest, write_simulation
    from simtip.simulation import simulate

    source = read_scene(scene)
    measuring_rig(source.spec)  # the folder will hold it, too: refused before long work
    OutputFolder(out).check()
    chosen = choose(backend)
    with located(source), progress_bar("rendering") as progress:
        done = simulate(source.spec, seed=seed, backend=chosen, progress=progress)
    with result_folder(out) as folder:
        write_simulation(folder, done, exr=exr, lights=lights)
        write_manifest(folder, done, done.timings_s)
    if as_json:
        truth = done.truth.to_dict()
        facts = {"scene": source.spec.name, "seed": done.seed, "backend": done.backend.variant}
        print_json({**facts, "out": str(out), "truth": truth, "timings_s": done.timings_s})
        return
    say_where(out, "left.png, right.png, truth.json")
