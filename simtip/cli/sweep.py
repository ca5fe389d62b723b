"""`simtip sweep`: many trials, none computed twice, none lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from simtip.cli.errors import fail
from simtip.cli.experiment import TimeLimitOption
from simtip.cli.options import BackendOption, JsonOption, named
from simtip.cli.output import print_json, say
from simtip.errors import InputError
from simtip.interrupts import INTERRUPTED, no_more, nothing_begun
from simtip.sweep.sizes import USUAL_SIZE

if TYPE_CHECKING:
    from simtip.sweep.plan import Plan
    from simtip.sweep.sweep_file import SweepFile
    from simtip.sweep.tally import Tally
    from simtip.sweep.work import Setup


def sweep(
    file: Annotated[Path, typer.Argument(parser=named, metavar="SWEEP", help="Sweep file (YAML).")],
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", parser=named, metavar="DIR", help="Folder of results; gone on with."
        ),
    ],
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=1, max=1024, help="Processes; by default one a core."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Dask's, e.g. tcp://host:8786."),
    ] = None,
    detector: Annotated[
        list[str] | None,
        typer.Option("--detector", metavar="REF", help="Instead of the file's; repeatable."),
    ] = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Also try again what failed.")
    ] = False,
    cache: Annotated[
        Path | None,
        typer.Option("--cache", parser=named, metavar="DIR", help="Of renders and images."),
    ] = None,
    cache_size: Annotated[
        str, typer.Option("--cache-size", metavar="SIZE", help="Its limit; 0 for no cache.")
    ] = USUAL_SIZE,
    time_limit: TimeLimitOption = 300.0,
    backend: BackendOption = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say how much there is to do.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Vary a scene and its detectors, and measure every combination."""
    if any(not one.strip() for one in detector or ()):
        raise InputError("is empty", field="--detector", remedy="name a detector")
    twice = next((one for one, count in Counter(detector or ()).items() if count > 1), None)
    if twice is not None:
        raise InputError(
            f"names {twice[:80]!r} twice",
            field="--detector",
            remedy="name it once, or in the sweep file under a label each",
        )
    if scheduler is not None and workers is not None:
        raise InputError(
            "is the cluster's affair", field="--workers", remedy="leave it out with --scheduler"
        )
    with nothing_begun():
        from simtip.sweep.campaign import Means, carry_out, prepare
        from simtip.sweep.resuming import rows_of
        from simtip.sweep.sweep_file import read_sweep

        source = read_sweep(file)
        with _located(source):
            plan = _plan(source, detector)
            means = Means(workers, scheduler, backend, cache, cache_size, time_limit)
            setup = prepare(plan, means)
            if dry_run:
                _foretell(plan, setup, means.local_workers, out, as_json=as_json)
                return
    try:
        with _located(source):
            tally = carry_out(plan, setup, out, means, retry_failed=retry_failed)
    except KeyboardInterrupt:
        no_more()
        fail(
            f"interrupted with {rows_of(out)} of {len(plan)} trials done; the same command goes on",
            INTERRUPTED,
        )
    said = summary_of(tally)
    if as_json:
        print_json({"out": str(out), **said})
    else:
        say(_in_words(said, out))


@contextmanager
def _located(source: SweepFile) -> Iterator[None]:
    """Give an error about a field the line in its file."""
    try:
        yield
    except InputError as error:
        if (error.field or "-").startswith("-"):
            raise
        raise source.located(error) from error


def _plan(source: SweepFile, detector: list[str] | None) -> Plan:
    from simtip.sweep.plan import Plan

    spec = source.spec
    if detector:
        spec = spec.model_copy(update={"detectors": list(detector)})
    try:
        return Plan(spec, source.scene, tuple(detector or ()), source.document.file)
    except InputError as error:
        if detector and (error.field or "").startswith("detectors"):
            raise InputError(error.problem, field="--detector", remedy=error.remedy) from error
        raise


def summary_of(tally: Tally) -> dict[str, Any]:
    """Give what a sweep did, as plain data."""
    return {
        "trials": tally.total,
        "found": tally.before,
        "done": tally.done,
        "failed": dict(sorted(tally.failed.items())),
        "worked_out": {name: tally.counts.get(name, 0) for name in ("light", "images", "measure")},
        "crashes": tally.crashes,
        "seconds": tally.seconds,
    }


def _in_words(said: dict[str, Any], out: Path) -> str:
    made = said["worked_out"]
    lines = [
        (
            f"{said['trials']} trials: {said['found']} found done, {said['done']} done now in "
            f"{said['seconds']:.1f} s"
        ),
        (
            f"worked out: {made['light']} renders, {made['images']} pairs of images, "
            f"{made['measure']} measurements"
        ),
    ]
    if said["failed"]:
        many = ", ".join(f"{count} {status}" for status, count in said["failed"].items())
        lines.append(f"without a tip: {many}")
    return "\n".join([*lines, f"written to {out}; see `simtip results {out}`"])


def _foretell(plan: Plan, setup: Setup, workers: int, out: Path, *, as_json: bool) -> None:
    from simtip.sweep.forecast import forecast, in_words
    from simtip.sweep.resuming import check_folder, rows_of

    check_folder(out)
    said = {**forecast(plan, setup, workers), "rows": rows_of(out)}
    if as_json:
        print_json(said)
    else:
        say(in_words(said))
