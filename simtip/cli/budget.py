"""`simtip budget`: where every micrometre of error comes from."""

from __future__ import annotations

from typing import Annotated

import typer

from simtip.cli.detector_options import SettingsOption
from simtip.cli.experiment import (
    CacheOption,
    CacheSizeOption,
    ExperimentOption,
    FolderOption,
    RetryFailedOption,
    SceneDetectorOption,
    SchedulerOption,
    WorkersOption,
    read_with,
    working_in,
)
from simtip.cli.options import BackendOption, JsonOption, SceneArgument, SeedOption
from simtip.cli.output import print_json, say_aside, say_where
from simtip.sweep.sizes import USUAL_SIZE


def budget(
    scene: SceneArgument,
    out: FolderOption = None,
    replicates: Annotated[
        int,
        typer.Option(
            "--replicates", min=2, max=1000, help="Draws of noise, calibration and reference."
        ),
    ] = 5,
    experiment: ExperimentOption = None,
    detector: SceneDetectorOption = None,
    settings: SettingsOption = None,
    seed: SeedOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    retry_failed: RetryFailedOption = False,
    cache: CacheOption = None,
    cache_size: CacheSizeOption = USUAL_SIZE,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Switch every cause of error off, one by one and together, and share the error out."""
    from simtip.budget.run import run_budget
    from simtip.console_budget import show_budget
    from simtip.sweep.campaign import Means

    source = read_with(scene, experiment, detector, settings)
    with working_in(source, out, experiment) as folder:
        done = run_budget(
            source.spec,
            folder,
            Means(workers, scheduler, backend, cache, cache_size),
            seed=seed,
            replicates=replicates,
            allowed=() if detector is None else (detector,),
            retry_failed=retry_failed,
            said=say_aside,
        )
        if out is not None:
            from simtip.budget.figure import budget_figure
            from simtip.output_folder import write_atomically

            write_atomically(folder / "budget.png", budget_figure(done))
    result = done.to_dict()
    if as_json:
        print_json(result)
        return
    show_budget(result)
    say_where(out, "budget.png, budget.json")
