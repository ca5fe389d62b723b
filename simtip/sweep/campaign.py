"""A sweep from its plan to its table: what works on it, where, and what is left of it."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from simtip.errors import InputError
from simtip.provenance import environment
from simtip.render import choose
from simtip.sweep.cache import Cache, default_folder
from simtip.sweep.forecast import megapixels_of
from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool
from simtip.sweep.progress import progress
from simtip.sweep.resuming import alone, as_json, open_table
from simtip.sweep.running import run_sweep
from simtip.sweep.sizes import USUAL_SIZE, parse_size
from simtip.sweep.speeds import keep_speeds
from simtip.sweep.tally import Tally
from simtip.sweep.work import Job, Setup, run_job

USUAL_LIMIT_S = 300.0


@dataclass(frozen=True)
class Means:
    """What a sweep is worked out with.

    Attributes
    ----------
    workers
        Processes of this machine; None is one a core.
    scheduler
        Address of a Dask cluster's, in their place.
    backend
        What renders; None is the best there is.
    cache
        Folder of renders and images; None is the user's own.
    cache_size
        Its limit, as text; "0" for no cache.
    time_limit_s
        Of a trial, without its render.
    """

    workers: int | None = None
    scheduler: str | None = None
    backend: str | None = None
    cache: Path | None = None
    cache_size: str = USUAL_SIZE
    time_limit_s: float = USUAL_LIMIT_S

    @property
    def local_workers(self) -> int:
        """How many processes of this machine there would be."""
        return self.workers or cores()

    def pool(self) -> Pool:
        """Make a pool for several sweeps, one after the other, to be closed after the last.

        Raises
        ------
        InputError
            See `Pool`.
        """
        return Pool(self.local_workers, self.scheduler, lasting=True)


def cores() -> int:
    """Give how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def prepare(plan: Plan, means: Means) -> Setup:
    """Give what all jobs of a sweep share.

    Raises
    ------
    InputError
        There is no such back end, the cache's size is none, or it cannot be written.
    """
    try:
        limit = parse_size(means.cache_size)
    except InputError as error:
        raise InputError(error.problem, field="--cache-size", remedy=error.remedy) from error
    folder = default_folder() if means.cache is None else means.cache
    if limit and means.cache is not None:
        Cache(folder, limit).check()
    sweep, scene = as_json(plan)
    kept = str(folder.absolute()) if limit else None
    chosen = choose(means.backend)
    return Setup(
        *(sweep, scene, plan.allowed, chosen.name, kept, limit, float(means.time_limit_s)),
        code=plan.code(chosen.variant),
    )


def carry_out(
    plan: Plan,
    setup: Setup,
    out: Path,
    means: Means,
    *,
    retry_failed: bool = False,
    shared: Pool | None = None,
) -> Tally:
    """Work out a sweep, or go on with it.

    Parameters
    ----------
    plan, setup
        What to do.
    out
        Folder of its table.
    means
        Where it is worked out.
    retry_failed
        Whether trials that failed are tried again.
    shared
        Works on several sweeps, one after the other, and is closed by the caller; None is one
        that `means` asks for.

    Raises
    ------
    InputError
        The folder holds something else or cannot be written, or the cluster does not answer.
    KeyboardInterrupt
        After the rows at hand were written: the same call goes on.
    """
    about = {
        **environment(),
        "backend": setup.backend,
        "sweep": setup.sweep,
        "scene": setup.scene,
    }
    pool = shared or Pool(min(means.local_workers, len(plan)), means.scheduler)
    workers = min(pool.workers, len(plan))
    if pool.local:
        renders = max(1, -(-len(plan) // plan.block))
        setup = replace(
            setup,
            threads=max(1, cores() // workers),
            light_threads=max(1, cores() // min(workers, renders)),
        )
    try:
        with alone(out):
            table, done = open_table(out, plan, about, setup.code, retry_failed=retry_failed)
            if not done.all():
                pool.get_ready(run_job, Job(setup, ()))
            table.compact()
            with progress(len(plan)) as report:
                tally = run_sweep(
                    plan,
                    table,
                    setup,
                    pool,
                    done=lambda number: bool(done[number]),
                    report=report,
                    before=int(done.sum()),
                )
            table.compact()
            keep_speeds(setup.cache, tally.spent.means(megapixels_of(plan)))
            return tally
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be written ({reason})",
            file=out,
            remedy="free some space and give the same command: it goes on",
        ) from error
    finally:
        if shared is None:
            pool.close()
