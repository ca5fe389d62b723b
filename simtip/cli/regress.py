"""`simtip regress`: whether a detector has become worse."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from simtip.cli.detector_options import SettingsOption, chatter_aside, parse_settings
from simtip.cli.errors import fail
from simtip.cli.experiment import CacheOption, CacheSizeOption, TimeLimitOption, WorkersOption
from simtip.cli.options import BackendOption, JsonOption, named
from simtip.cli.output import print_json, say_aside, say_where
from simtip.errors import InputError
from simtip.interrupts import INTERRUPTED
from simtip.seeding import SEED_LIMIT
from simtip.sweep.sizes import USUAL_SIZE

if TYPE_CHECKING:
    from simtip.regress.baseline import Baseline
    from simtip.regress.check import Outcome
    from simtip.regress.suite import Suite
    from simtip.sweep.campaign import Means

SUMMARY = "GITHUB_STEP_SUMMARY"

BaselineArgument = Annotated[
    Path, typer.Argument(parser=named, metavar="BASELINE", help="File of `regress record`.")
]
CandidateOption = Annotated[
    str | None,
    typer.Option("--detector", metavar="REF", help="Instead of the baseline's detector."),
]
NoiseOption = Annotated[
    int | None,
    typer.Option("--seed", min=0, max=SEED_LIMIT - 1, help="Of the noise, instead of the suite's."),
]

regress = typer.Typer(help="Has a detector become worse? Record a baseline, check against it.")


@regress.command("record")
def record_baseline(
    suite: Annotated[str, typer.Argument(metavar="SUITE", help="Suite file (YAML), or standard.")],
    out: Annotated[
        Path, typer.Option("-o", "--out", parser=named, metavar="BASELINE", help="A new file.")
    ],
    detector: Annotated[
        str | None,
        typer.Option("--detector", metavar="REF", help="Instead of the scenes' own detector."),
    ] = None,
    settings: SettingsOption = None,
    seed: NoiseOption = None,
    workers: WorkersOption = None,
    cache: CacheOption = None,
    cache_size: CacheSizeOption = USUAL_SIZE,
    time_limit: TimeLimitOption = 300.0,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Try a detector on a suite, and keep what it finds as a baseline."""
    from simtip.console_regress import show_baseline
    from simtip.output_folder import check_new_file
    from simtip.regress.baseline_file import ENDINGS, write_baseline
    from simtip.regress.chosen import Chosen
    from simtip.regress.record import record
    from simtip.regress.suite import read_suite
    from simtip.sweep.campaign import Means

    check_new_file(out, ENDINGS)
    _check_name(detector)
    chosen = Chosen(detector, parse_settings(settings), detector is not None)
    read = read_suite(suite)
    means = Means(workers, None, backend, cache, cache_size, time_limit)
    with _working_in(None) as folder, chatter_aside():
        made = record(
            *(read, chosen, out, folder, means),
            seed=seed,
            said=say_aside,
        )
    write_baseline(out, made)
    if as_json:
        print_json(made.model_dump(mode="json"))
        return
    show_baseline(made, "recorded")
    say_where(out, "review it, and keep it with your detector")


@regress.command("check")
def check_baseline(
    file: BaselineArgument,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", parser=named, metavar="DIR", help="Folder of results; gone on with."
        ),
    ] = None,
    detector: CandidateOption = None,
    settings: SettingsOption = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", min=0, max=SEED_LIMIT - 1, help="Fresh noise: compare statistically."
        ),
    ] = None,
    junit: Annotated[
        Path | None,
        typer.Option("--junit", parser=named, metavar="FILE", help="Write JUnit XML."),
    ] = None,
    summary: Annotated[
        Path | None,
        typer.Option(
            "--summary",
            parser=named,
            metavar="FILE",
            help=f"Write GitHub Markdown; without it, it is added to ${SUMMARY} if that is set.",
        ),
    ] = None,
    workers: WorkersOption = None,
    cache: CacheOption = None,
    cache_size: CacheSizeOption = USUAL_SIZE,
    time_limit: TimeLimitOption = 300.0,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Hold a detector to a baseline: exit code 0 same or better, 1 worse, 2 could not tell."""
    from simtip.console_regress import show_check
    from simtip.output_folder import check_writable, write_atomically
    from simtip.regress.junit import junit_of
    from simtip.regress.markdown import markdown_of
    from simtip.regress.result import result_of, write_result
    from simtip.sweep.campaign import Means

    added = (os.environ.get(SUMMARY) or None) if summary is None else None
    for place in (junit, summary):
        if place is not None:
            check_writable(place)
    if added is not None:
        _check_appendable(Path(added))
    baseline, suite = _read(file)
    outcome = _checked(
        *(baseline, suite, out, detector, settings, seed, None),
        Means(workers, None, backend, cache, cache_size, time_limit),
    )
    result = result_of(outcome, file)
    try:
        if out is not None:
            write_result(out, result)
        if junit is not None:
            write_atomically(junit, junit_of(result))
        if summary is not None:
            write_atomically(summary, markdown_of(result).encode())
        elif added:
            _add(Path(added), markdown_of(result))
    finally:
        # A disk that is full by now does not lose what was found.
        if as_json:
            print_json(result)
        else:
            show_check(result)
    if not as_json:
        say_where(out, "regress.json")
    raise typer.Exit(outcome.exit_code)


@regress.command("update")
def update_baseline(
    file: BaselineArgument,
    reason: Annotated[
        str, typer.Option("--reason", metavar="TEXT", help="Why; kept in the baseline.")
    ],
    cases: Annotated[
        list[str] | None,
        typer.Option("--case", metavar="NAME", help="Whose change is accepted; repeatable."),
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="All cases.")] = False,
    detector: CandidateOption = None,
    settings: SettingsOption = None,
    workers: WorkersOption = None,
    cache: CacheOption = None,
    cache_size: CacheSizeOption = USUAL_SIZE,
    time_limit: TimeLimitOption = 300.0,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Accept changes: work cases out anew, and replace their results in the baseline."""
    from simtip.console_regress import show_baseline
    from simtip.output_folder import check_writable
    from simtip.regress.baseline_file import write_baseline
    from simtip.regress.record import updated
    from simtip.sweep.campaign import Means

    if not reason.strip():
        raise InputError("is empty", field="--reason", remedy="say why the change is right")
    if every == bool(cases):
        raise InputError(
            "names no case" if not cases else "stands beside --case",
            field="--case" if not cases else "--all",
            remedy="name cases by --case NAME, or give --all",
        )
    check_writable(file)
    baseline, suite = _read(file)
    names = None if every else _known(cases or [], suite)
    if names is not None and (detector is not None or settings):
        _refuse_other(baseline, detector, settings)
    outcome = _checked(
        *(baseline, suite, None, detector, settings, None, names),
        Means(workers, None, backend, cache, cache_size, time_limit),
    )
    made = updated(baseline, outcome, suite, file, names, reason.strip())
    write_baseline(file, made)
    if as_json:
        print_json(made.model_dump(mode="json"))
        return
    show_baseline(made, "updated")
    say_where(file, f"{len(outcome.cases)} cases accepted")


def _read(file: Path) -> tuple[Baseline, Suite]:
    """Read a baseline and the suite that it names."""
    from simtip.regress.baseline_file import read_baseline
    from simtip.regress.recorded import suite_of
    from simtip.regress.suite import read_suite

    baseline = read_baseline(file)
    path = Path(suite_of(baseline.suite, file))
    try:
        there = path.exists()
    except OSError:  # too long a name, for example
        there = False
    if not there:
        raise InputError(
            f"names the suite {baseline.suite.file[:200]}, and there is no such file",
            file=file,
            field="suite.file",
            remedy="put it back where it was, seen from the baseline",
        )
    return baseline, read_suite(path)


def _checked(
    baseline: Baseline,
    suite: Suite,
    out: Path | None,
    detector: str | None,
    settings: list[str] | None,
    seed: int | None,
    only: list[str] | None,
    means: Means,
) -> Outcome:
    from simtip.regress.check import check
    from simtip.regress.chosen import chosen_for

    _check_name(detector)
    chosen = chosen_for(baseline.detector, detector, parse_settings(settings))
    with _working_in(out) as folder, chatter_aside():
        return check(
            *(baseline, suite, chosen, folder, means),
            seed=seed,
            only=only,
            said=say_aside,
        )


@contextmanager
def _working_in(out: Path | None) -> Iterator[Path]:
    """Give the folder to work in, a temporary one if none is named; Ctrl-C ends in one line."""
    import tempfile

    from simtip.regress.folder import check_folder
    from simtip.sweep.resuming import alone

    try:
        if out is None:
            with tempfile.TemporaryDirectory(prefix="simtip-") as folder:
                yield Path(folder)
            return
        check_folder(out)
        with alone(out):
            yield out
    except KeyboardInterrupt:
        kept = "what is done is in the cache" if out is None else "the same command goes on"
        fail(f"interrupted; {kept}", INTERRUPTED)


def _check_name(detector: str | None) -> None:
    if detector is not None and not detector.strip():
        raise InputError("is empty", field="--detector", remedy="name a detector")


def _check_appendable(path: Path) -> None:
    """Refuse early a summary of a job that could not be added to."""
    from simtip.output_folder import check_writable

    if not path.exists():
        check_writable(path)
    elif path.is_dir() or not os.access(path, os.W_OK):
        raise InputError("cannot be written", file=path, remedy=f"unset {SUMMARY}")


def _add(path: Path, text: str) -> None:
    """Add to a file, as the summary of a GitHub job is."""
    try:
        with path.open("a", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})", file=path, remedy=f"unset {SUMMARY}"
        ) from error


def _known(cases: list[str], suite: Suite) -> list[str]:
    import difflib

    known = [case.name for case in suite.cases]
    for name in cases:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            remedy = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
            raise InputError(f"there is no case {name[:80]!r}", field="--case", remedy=remedy)
    return list(dict.fromkeys(cases))


def _refuse_other(baseline: Baseline, detector: str | None, settings: list[str] | None) -> None:
    """Refuse to mix two detectors in a baseline."""
    values: dict[str, Any] = dict(parse_settings(settings))
    same = detector in (None, baseline.detector.name)
    if not same or any(baseline.detector.parameters.get(k) != v for k, v in values.items()):
        raise InputError(
            "is another detector than the baseline's, which is of one",
            field="--detector" if not same else "--set",
            remedy="give --all to accept it for all cases",
        )
