"""`simtip bound`: how well a scene's images allow its tip to be measured."""

from __future__ import annotations

from typing import Annotated

import typer

from simtip.cli.errors import located
from simtip.cli.options import BackendOption, JsonOption, OutOption, SceneArgument, SeedOption
from simtip.cli.output import print_json, say_where, to_stdout
from simtip.scene_file import read_scene


def bound(
    scene: SceneArgument,
    out: OutOption = None,
    seed: SeedOption = None,
    backend: BackendOption = None,
    samples: Annotated[
        int,
        typer.Option(
            "--samples", metavar="N", min=8, max=4096, help="Of a pixel at the needle's edge."
        ),
    ] = 256,
    as_json: JsonOption = False,
) -> None:
    """Give the Cramer-Rao bound of a scene's tip: the least error that any method can have."""
    from simtip.bound import tip_bound
    from simtip.bound_folder import write_bound
    from simtip.console import progress_bar
    from simtip.console_bound import show_bound
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose

    source = read_scene(scene)
    if out is not None:
        OutputFolder(out).check()
    chosen = choose(backend)
    with located(source), progress_bar("bound") as progress:
        found = tip_bound(
            source.spec, seed=seed, backend=chosen, samples=samples, progress=progress
        )
    result = found.to_dict()
    if out is not None:
        with result_folder(out) as folder:
            write_bound(folder, found)
    if as_json:
        print_json(result)
        return
    with to_stdout():
        show_bound(result)
    say_where(out, "bound.json, left_information.png, right_information.png")
