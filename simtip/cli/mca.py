"""`simtip mca`: measurement capability, by the scene's experiment or of measurements in a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

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
    changed,
    read_with,
    working_in,
)
from simtip.cli.options import BackendOption, JsonOption, SeedOption, named
from simtip.cli.output import print_json, say_aside, say_where
from simtip.errors import InputError
from simtip.sweep.sizes import USUAL_SIZE

if TYPE_CHECKING:
    from simtip.capability.report import Settings

OF_CSV = ("readings", "repeated", "columns")
BOTH = "give SCENE or --csv FILE"
OF_SCENE = (
    *("out", "seed", "detector", "settings", "experiment", "workers"),
    *("scheduler", "frame", "retry_failed", "cache", "cache_size", "backend"),
)


def mca(
    context: typer.Context,
    scene: Annotated[
        Path | None,
        typer.Argument(parser=named, metavar="[SCENE]", help="Scene file; its experiment is run."),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            "--csv",
            parser=named,
            metavar="FILE",
            help="Measurements instead: a header, then a row each. Columns: measured; reference "
            "for accuracy and agreement; part for repeatability; operator for gauge R&R; trial; "
            "run.",
        ),
    ] = None,
    out: FolderOption = None,
    tolerance: Annotated[
        float | None,
        typer.Option("--tolerance", metavar="T", help="USL - LSL, mm, or in the unit of the file."),
    ] = None,
    multiplier: Annotated[
        float | None,
        typer.Option("--multiplier", metavar="K", help="Of P/T: 6, or 5.15 as of old."),
    ] = None,
    level: Annotated[
        float | None,
        typer.Option(
            "--level", metavar="P", help="Confidence level of all intervals; 0.95 by default."
        ),
    ] = None,
    readings: Annotated[
        Literal["displacement", "position", "step"],
        typer.Option(
            "--readings",
            help="What a row holds: displacement from the run's start, position, or step.",
        ),
    ] = "displacement",
    repeated: Annotated[
        Literal["varies", "constant"] | None,
        typer.Option(
            "--repeated",
            help="Limits of agreement for several pairs per part: its true value varies or is "
            "constant. By default every pair counts as independent.",
        ),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option(
            "--column",
            metavar="NAME=HEADER",
            help="The file's own header of a column, e.g. reference=xl80; repeatable.",
        ),
    ] = None,
    experiment: ExperimentOption = None,
    detector: SceneDetectorOption = None,
    settings: SettingsOption = None,
    seed: SeedOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    frame: Annotated[
        Literal["camera", "stage"],
        typer.Option("--frame", help="Of position errors: the left camera's, or the stage's own."),
    ] = "camera",
    retry_failed: RetryFailedOption = False,
    cache: CacheOption = None,
    cache_size: CacheSizeOption = USUAL_SIZE,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Analyse accuracy, agreement, repeatability and gauge R&R, with intervals.

    Of a scene: the needle is driven along a stage and measured, as its `experiment` says. With
    --csv: of measurements in a file.
    """
    _check(level, tolerance, multiplier)
    _refuse_strangers(context, of_file=csv is not None)
    if scene is not None and csv is not None:
        raise InputError("takes one of the two", field="mca", remedy=BOTH)
    if scene is None:
        if csv is None:
            raise InputError("needs a scene, or measurements", field="mca", remedy=BOTH)
        from simtip.capability.report import Settings

        chosen = Settings(readings, repeated, tolerance, multiplier or 6.0, level or 0.95)
        _from_file(csv, columns or [], chosen, as_json=as_json)
        return
    from simtip.console_capability import show_experiment
    from simtip.experiment.run import run_experiment
    from simtip.sweep.campaign import Means

    source = read_with(scene, experiment, detector, settings)
    source = changed(source, tolerance_mm=tolerance, multiplier=multiplier, level=level)
    if frame == "stage" and not source.spec.experiment.schedule.registration:
        raise InputError(
            "is unknown: the experiment registers no frame of the stage",
            field="--frame",
            remedy="give experiment.schedule.registration, or leave --frame out",
        )
    with working_in(source, out, experiment) as folder:
        done = run_experiment(
            source.spec,
            folder,
            Means(workers, scheduler, backend, cache, cache_size),
            seed=seed,
            allowed=() if detector is None else (detector,),
            retry_failed=retry_failed,
            frame=frame,
            said=say_aside,
        )
        if out is not None:
            from simtip.experiment.figures import write_figures

            write_figures(folder, done.capability)
    result = done.to_dict()
    if as_json:
        print_json(result)
        return
    show_experiment(result)
    say_where(out, "mca.json, measurements.csv, accuracy.png, agreement.png, ..")


def _refuse_strangers(context: typer.Context, *, of_file: bool) -> None:
    """Refuse options of the other kind of input."""
    for name in OF_SCENE if of_file else OF_CSV:
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE":
            option = next(p for p in context.command.params if p.name == name).opts[-1]
            whose = "a scene" if of_file else "--csv"
            raise InputError(f"goes with {whose} only", field=option, remedy="leave it out")


def _from_file(csv: Path, columns: list[str], chosen: Settings, *, as_json: bool) -> None:
    from simtip.capability.report import report_on
    from simtip.capability.table import read_table
    from simtip.console_capability import show_capability

    table = read_table(csv, _columns(columns))
    result = report_on(table, chosen).to_dict()
    if as_json:
        print_json(result)
        return
    show_capability(result)


def _check(level: float | None, tolerance: float | None, multiplier: float | None) -> None:
    if level is not None and not 0.5 <= level <= 0.9999:
        raise InputError(
            f"is {level:g}, and not between 0.5 and 0.9999",
            field="--level",
            remedy="0.95 is 95 %",
        )
    for option, number in (("--tolerance", tolerance), ("--multiplier", multiplier)):
        if number is not None and not (math.isfinite(number) and 1e-30 <= number <= 1e30):
            raise InputError(
                f"is {number:g}", field=option, remedy="give a number above 0, as 0.62"
            )


def _columns(texts: list[str]) -> dict[str, str]:
    from simtip.capability.table import COLUMNS

    found: dict[str, str] = {}
    for text in texts:
        name, sign, header = (part.strip() for part in text.partition("="))
        if not sign or not header or name not in COLUMNS:
            raise InputError(
                f"{text[:80]!r} is not NAME=HEADER",
                field="--column",
                remedy=f"NAME is one of {', '.join(COLUMNS)}",
            )
        if name in found:
            raise InputError(
                f"{name} is there twice", field="--column", remedy="name one header for it"
            )
        found[name] = header
    return found
