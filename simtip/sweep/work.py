"""What a worker process does: a job of some trials, one after the other.

A job is small and plain: the sweep as data, and which trials. What a process needs to work, it
makes once and keeps for the jobs that follow.
"""

from __future__ import annotations

import contextlib
import threading
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from simtip.detect import process
from simtip.errors import InputError
from simtip.render import choose
from simtip.spec import SceneSpec
from simtip.sweep.cache import Cache
from simtip.sweep.leaving import leaving_at_once
from simtip.sweep.limit import Limit
from simtip.sweep.note import Note
from simtip.sweep.plan import Plan
from simtip.sweep.spec import SweepSpec
from simtip.sweep.stages import Stages
from simtip.sweep.threads import use_threads

Row = dict[str, object]


@dataclass(frozen=True)
class Setup:
    """What all jobs of a sweep share.

    Attributes
    ----------
    sweep, scene
        As JSON.
    allowed
        Detectors that are programs or modules, which the user is willing to run.
    backend
        What renders: "auto" or a name.
    cache, cache_bytes
        Folder of the cache, None for none; and its limit.
    time_limit_s
        Of a trial once its light is there: after it the process ends itself.
    code
        That rows are made by.
    threads, light_threads
        That a process may use, and that it may render with: all, if there are few renders; None is
        all.
    """

    sweep: str
    scene: str
    allowed: tuple[str, ...]
    backend: str
    cache: str | None
    cache_bytes: int
    time_limit_s: float
    code: str = ""
    threads: int | None = None
    light_threads: int | None = None


@dataclass(frozen=True)
class Job:
    """Some trials.

    Attributes
    ----------
    setup
        Of the sweep.
    trials
        Their numbers; with none, a process just gets ready.
    only_light
        Whether only the first one's light is wanted.
    note
        File that says which of them is at work, see `simtip.sweep.note`.
    """

    setup: Setup
    trials: tuple[int, ...]
    only_light: bool = False
    note: str | None = None


@dataclass(frozen=True)
class Done:
    """What became of a job.

    Attributes
    ----------
    rows
        One a trial.
    counts
        How often each stage was worked out.
    seconds
        Wall time.
    rest
        Trials that are left: the job would have taken too long.
    render_s
        Of that, what rendering took where only light was wanted.
    """

    rows: list[Row]
    counts: dict[str, int]
    seconds: float
    render_s: float | None = None
    rest: tuple[int, ...] = ()


LONGEST_JOB_S = 4.0
"""After which a job comes back with what it has: rows shall not wait for long to be written."""

PROGRAMS_SHARE = 0.45
"""Of a trial's time, what a detector's program may take for one image."""

_TURN = threading.Lock()
"""One job at a time in a process: threads of a cluster's worker share what is kept."""


def run_job(job: Job) -> Done:
    """Work out a job's trials."""
    with _TURN:
        return _run(job)


def _run(job: Job) -> Done:
    start = time.perf_counter()
    with leaving_at_once():
        plan, stages = workshop(job.setup)
    before = dict(stages.counts)
    rows: list[Row] = []
    render_s = None
    if job.only_light:
        with contextlib.suppress(InputError):  # its trials will say so
            render_s = stages.light(plan.trial(job.trials[0]))
    else:
        with Note(job.note) as note:
            stages.limit.told = note.descriptor
            for number in job.trials:
                if rows and time.perf_counter() - start > LONGEST_JOB_S:
                    break
                note.at(number)
                with stages.limit:
                    rows.append(stages.row(plan.trial(number)))
        stages.limit.told = None
    counts = {name: count - before[name] for name, count in stages.counts.items()}
    rest = () if job.only_light else job.trials[len(rows) :]
    return Done(rows, counts, time.perf_counter() - start, render_s, rest)


@lru_cache(maxsize=2)
def workshop(setup: Setup) -> tuple[Plan, Stages]:
    """Make what a process needs for a sweep."""
    spec = SweepSpec.model_validate_json(setup.sweep, strict=True)
    scene = SceneSpec.model_validate_json(setup.scene, strict=True)
    plan = Plan(spec, scene, setup.allowed)
    backend = choose(setup.backend)
    # Each view's program ends before the trial's time does, which would leave it running.
    process.LONGEST_S = PROGRAMS_SHARE * setup.time_limit_s
    if setup.threads is not None:
        use_threads(setup.threads)
    cache = None if setup.cache is None else Cache(Path(setup.cache), setup.cache_bytes)
    return plan, Stages(
        plan, cache, backend, Limit(setup.time_limit_s), threads=setup.light_threads
    )
