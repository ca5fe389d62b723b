"""`simtip bound`: how well a scene's images allow its tip to be measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.seeding import SEED_LIMIT


def bound(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (YAML).")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="New or empty folder for results."),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", min=0, max=SEED_LIMIT - 1, help="Root seed, instead of the scene's own."
        ),
    ] = None,
    backend: Annotated[
        str | None,
        typer.Option("--backend", metavar="NAME", help="auto, cuda or llvm [default: auto]."),
    ] = None,
    samples: Annotated[
        int,
        typer.Option(
            "--samples", metavar="N", min=8, max=4096, help="Of a pixel at the needle's edge."
        ),
    ] = 256,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")] = False,
) -> None:
    """Give the Cramer-Rao bound of a scene's tip: the least error that any method can have."""
    # Here, not above: `simtip.cli` imports this module.
    from simtip.bound import tip_bound
    from simtip.bound_folder import write_bound
    from simtip.cli import _print_json, _say_where, _to_stdout, located
    from simtip.console import progress_bar
    from simtip.console_bound import show_bound
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose
    from simtip.scene_file import read_scene

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
        _print_json(result)
        return
    with _to_stdout():
        show_bound(result)
    _say_where(out, "bound.json, left_information.png, right_information.png")
