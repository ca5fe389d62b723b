"""A sweep run in its folder, with its progress shown. Loads all that a sweep needs."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from simtip.cli.errors import fail
from simtip.errors import InputError
from simtip.interrupts import INTERRUPTED, no_more
from simtip.provenance import environment
from simtip.sweep.forecast import megapixels_of
from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool
from simtip.sweep.progress import progress
from simtip.sweep.resuming import alone, open_table, rows_of
from simtip.sweep.running import run_sweep
from simtip.sweep.speeds import keep_speeds
from simtip.sweep.tally import Tally
from simtip.sweep.work import Job, Setup, run_job


def cores() -> int:
    """Give how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_in(
    out: Path,
    plan: Plan,
    setup: Setup,
    workers: int,
    scheduler: str | None,
    *,
    retry_failed: bool,
) -> Tally:
    """Run a sweep, or what is left of it.

    Parameters
    ----------
    out
        Its folder.
    plan, setup
        What to do.
    workers, scheduler
        Where, see `simtip.sweep.pool.Pool`.
    retry_failed
        Whether trials without a tip are tried again.

    Raises
    ------
    InputError
        The folder cannot be written, or the cluster cannot be reached.
    """
    workers = min(workers, len(plan))
    pool = Pool(workers, scheduler)
    if pool.local:
        renders = max(1, -(-len(plan) // plan.block))
        setup = replace(
            setup,
            threads=max(1, cores() // workers),
            light_threads=max(1, cores() // min(workers, renders)),
        )
    try:
        with alone(out):
            try:
                return _run(out, plan, setup, pool, retry_failed=retry_failed)
            except KeyboardInterrupt:
                no_more()
                kept = rows_of(out)
                fail(
                    f"interrupted with {kept} of {len(plan)} trials done; the same command goes on",
                    INTERRUPTED,
                )
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be written ({reason})",
            file=out,
            remedy="free some space and give the same command: it goes on",
        ) from error
    finally:
        pool.close()


def _run(out: Path, plan: Plan, setup: Setup, pool: Pool, *, retry_failed: bool) -> Tally:
    about = {
        **environment(),
        "backend": setup.backend,
        "sweep": setup.sweep,
        "scene": setup.scene,
    }
    pool.get_ready(run_job, Job(setup, ()))
    table, done = open_table(out, plan, about, setup.code, retry_failed=retry_failed)
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
