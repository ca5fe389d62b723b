"""`simtip boards`: calibration images with known truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from simtip.cli.errors import as_option, fail, located
from simtip.cli.options import BackendOption, JsonOption, SceneArgument, SeedOption, named
from simtip.cli.output import print_json, say, say_where
from simtip.interrupts import INTERRUPTED
from simtip.scene_file import read_scene


def boards(
    scene: SceneArgument,
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", parser=named, metavar="DIR", help="New folder, or one begun before."
        ),
    ],
    views: Annotated[
        int | None,
        typer.Option("--views", metavar="N", min=1, max=10_000, help="Instead of the scene's."),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option("--target", metavar="TARGET", help="E.g. chessboard:11x8:6 (inner corners)."),
    ] = None,
    seed: SeedOption = None,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Render calibration images with known truth: left_01.png, right_01.png, ..., truth.json.

    A run that was stopped goes on where it was.
    """
    from simtip.boards import plan_boards
    from simtip.boards_folder import check_folder, fill_folder
    from simtip.console import progress_bar
    from simtip.render import choose
    from simtip.target import parse_target

    source = read_scene(scene)
    wanted: dict[str, Any] = {} if views is None else {"views": views}
    if target is not None:
        with as_option("--target"):
            wanted["target"] = str(parse_target(target))
    shown = source.spec.boards.model_copy(update=wanted)
    spec = source.spec.model_copy(update={"boards": shown})
    with located(source):
        plan = plan_boards(spec, seed=seed)
    check_folder(out, plan)
    chosen = choose(backend)
    try:
        with located(source), progress_bar("rendering boards") as progress:
            rendered, found = fill_folder(out, plan, backend=chosen, progress=progress)
    except KeyboardInterrupt:
        fail(f"interrupted; the same command goes on with {out}", INTERRUPTED)
    if as_json:
        facts = {"scene": spec.name, "seed": plan.seed, "backend": chosen.variant}
        counts = {"views": len(plan.poses), "rendered": rendered, "found": found}
        print_json({**facts, "out": str(out), "target": str(plan.plate.target), **counts})
        return
    say(f"{rendered} views rendered, {found} were there")
    say_where(out, "left_*.png, right_*.png, truth.json, rig_true.yaml")
