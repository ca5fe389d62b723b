"""`simtip run`: render, measure, score."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.detector_options import (
    SettingsOption,
    as_detector_options,
    chatter_aside,
    parse_settings,
    quiet,
)
from simtip.cli.errors import located
from simtip.cli.options import (
    BackendOption,
    JsonOption,
    OutOption,
    SceneArgument,
    SeedOption,
    named,
)
from simtip.cli.output import print_json, say_where, to_stdout
from simtip.scene_file import read_scene
from simtip.seeding import SEED_LIMIT


def run(
    scene: SceneArgument,
    out: OutOption = None,
    seed: SeedOption = None,
    backend: BackendOption = None,
    detector: Annotated[
        str | None,
        typer.Option("--detector", metavar="REF", help="Instead of the scene's own detector."),
    ] = None,
    settings: SettingsOption = None,
    bound: Annotated[
        Path | None,
        typer.Option(
            "--bound",
            parser=named,
            metavar="FILE",
            help="JSON of `simtip bound` of this scene, for efficiency.",
        ),
    ] = None,
    noise_seed: Annotated[
        int | None,
        typer.Option(
            "--noise-seed",
            min=0,
            max=SEED_LIMIT - 1,
            help="Of the sensors' noise alone: noise_seed of a sweep's table.",
        ),
    ] = None,
    light: Annotated[
        Path | None,
        typer.Option(
            "--light",
            parser=named,
            metavar="SCENE",
            help="Scene to render the light for, as a sweep does; lit alike.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Render a scene, measure the needle tip, score it against the truth."""
    from simtip.bound_file import read_bound
    from simtip.console import progress_bar, show_result
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose
    from simtip.result_folder import write_manifest, write_simulation, write_trial
    from simtip.trial import detector_of, run_trial, with_detector

    source = read_scene(scene)
    if out is not None:
        OutputFolder(out).check()
    known = None if bound is None else read_bound(bound)
    lit = None if light is None else read_scene(light).spec
    values = parse_settings(settings)
    spec = with_detector(source.spec, detector, values)
    given = {*values, *(() if detector is None else ("name",))}
    with located(source), as_detector_options(given), chatter_aside():
        chosen_detector = quiet(detector_of(spec, allowed=detector))
    chosen = choose(backend)
    with located(source), progress_bar("rendering") as progress:
        trial = run_trial(
            spec,
            seed=seed,
            backend=chosen,
            progress=progress,
            detector=chosen_detector,
            bound=known,
            noise_seed=noise_seed,
            light=lit,
        )
    result = trial.to_dict()
    if out is not None:
        with result_folder(out) as folder:
            write_simulation(folder, trial.simulation)
            write_trial(folder, trial)
            write_manifest(folder, trial.simulation, result["timings_s"])
    if as_json:
        print_json(result)
        return
    with to_stdout():
        show_result(result)
    say_where(out, "overlay.png, result.json")
