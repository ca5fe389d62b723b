"""What commands that run a scene's experiment share."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from simtip.cli.detector_options import as_detector_options, parse_settings
from simtip.cli.errors import fail, located
from simtip.cli.options import named
from simtip.errors import InputError
from simtip.interrupts import INTERRUPTED
from simtip.scene_file import SceneFile, read_scene

if TYPE_CHECKING:
    from simtip.spec.experiment import ExperimentSpec

FolderOption = Annotated[
    Path | None,
    typer.Option(
        "-o", "--out", parser=named, metavar="DIR", help="Folder of results; gone on with."
    ),
]
ExperimentOption = Annotated[
    Path | None,
    typer.Option(
        "--experiment", parser=named, metavar="FILE", help="YAML, instead of the scene's own."
    ),
]
SceneDetectorOption = Annotated[
    str | None,
    typer.Option("--detector", metavar="REF", help="Instead of the scene's own detector."),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", min=1, max=1024, help="Processes; by default one a core."),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Dask's, e.g. tcp://host:8786."),
]
CacheOption = Annotated[
    Path | None, typer.Option("--cache", parser=named, metavar="DIR", help="Of renders and images.")
]
CacheSizeOption = Annotated[
    str, typer.Option("--cache-size", metavar="SIZE", help="Its limit; 0 for no cache.")
]
TimeLimitOption = Annotated[
    float,
    typer.Option("--time-limit", min=0.1, metavar="S", help="Of a trial, without its render."),
]
RetryFailedOption = Annotated[
    bool, typer.Option("--retry-failed", help="Also try again what failed.")
]


def read_with(
    scene: Path, experiment: Path | None, detector: str | None, settings: list[str] | None
) -> SceneFile:
    """Read a scene, with another experiment or detector than its own, and check them.

    Raises
    ------
    InputError
        Whatever is wrong first.
    """
    from simtip.experiment_file import read_experiment
    from simtip.trial import detector_of, with_detector

    source = read_scene(scene)
    values = parse_settings(settings)
    spec = with_detector(source.spec, detector, values)
    if experiment is not None:
        spec = spec.model_copy(update={"experiment": read_experiment(experiment)})
    given = {*values, *(() if detector is None else ("name",))}
    with located(source), as_detector_options(given):
        detector_of(spec, allowed=detector)
    return replace(source, spec=spec)


def changed(source: SceneFile, **values: object) -> SceneFile:
    """Give a scene whose experiment has other values; those that are None stay."""
    given = {name: value for name, value in values.items() if value is not None}
    spec: ExperimentSpec = source.spec.experiment.model_copy(update=given)
    return replace(source, spec=source.spec.model_copy(update={"experiment": spec}))


@contextmanager
def _located(source: SceneFile, experiment: Path | None) -> Iterator[None]:
    """Give an error its place, in the scene or in the file of its experiment."""
    try:
        with located(source):
            yield
    except InputError as error:
        field = error.field or ""
        if experiment is None or not field.startswith("experiment."):
            raise
        raise InputError(
            error.problem,
            file=experiment,
            field=field.removeprefix("experiment."),
            remedy=error.remedy,
        ) from error


@contextmanager
def working_in(
    source: SceneFile, out: Path | None, experiment: Path | None = None
) -> Iterator[Path]:
    """Give the folder to work in, a temporary one if none is named; Ctrl-C ends in one line."""
    if out is not None and not str(out).strip(". "):
        raise InputError("is no folder of its own", field="--out", remedy="name a new folder")
    try:
        with _located(source, experiment):
            if out is not None:
                yield out
                return
            with tempfile.TemporaryDirectory(prefix="simtip-") as folder:
                yield Path(folder)
    except KeyboardInterrupt:
        kept = "what is done is in the cache" if out is None else "the same command goes on"
        fail(f"interrupted; {kept}", INTERRUPTED)
