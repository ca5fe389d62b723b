"""Run a sweep: hand out jobs, take in rows, go on when a worker dies.

Of every block of trials that share a render, the light comes first, once; then its trials follow in
jobs of a few seconds. Rows are written as they come. A trial that ends its process becomes a row
with its reason; the others of its job are handed out again.
"""

from __future__ import annotations

import itertools
import shutil
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from pathlib import Path

from simtip.errors import InputError
from simtip.interrupts import Presses, counted
from simtip.sweep.crashes import Crashes
from simtip.sweep.note import read_note
from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool, clear_up, exit_code, is_crash, stop
from simtip.sweep.rows import Form, failed
from simtip.sweep.table import OK, Table
from simtip.sweep.tally import Report, Tally
from simtip.sweep.work import Done, Job, Row, Setup, run_job

JOB_S = 2.0
"""What a job should take."""

MOST_IN_JOB = 2000

FIRST_IN_JOB = 2
"""Trials of a job while nothing is known of how long they take."""

PARTING_S = 8.0
"""After Ctrl-C, for jobs in flight to come to their end."""

LOOK_S = 0.2
"""So often it is looked whether Ctrl-C was pressed."""

FLUSH_S = 2.0
"""Rows are written so often."""

FLUSH_ROWS = 20_000

MERGED_EVERY = 64
"""Parts that are written, after which the table is asked to merge small ones."""

MOST_WAITING = 64
"""Groups of trials that wait for their light, beforehand."""

NOTES = ".notes"
"""In the sweep's folder: what workers are at."""

MOST_LIGHT_TRIES = 2
"""Of a block's light; then its trials find out for themselves what ends the process."""

Work = Callable[[Job], Done]


def run_sweep(
    plan: Plan,
    table: Table,
    setup: Setup,
    pool: Pool,
    *,
    done: Callable[[int], bool],
    report: Report = lambda _: None,
    work: Work = run_job,
    before: int = 0,
) -> Tally:
    """Work out the trials of a plan that are not done yet.

    Parameters
    ----------
    plan, setup
        What to do.
    table
        Takes the rows.
    pool
        Where.
    done
        Says of a trial's number whether its row is there already.
    report
        Called now and then.
    work
        What is done with a job, in a worker.
    before
        How many trials are done already.

    Raises
    ------
    OSError
        Rows cannot be written. All that were written before are there.
    KeyboardInterrupt
        After the rows at hand were written.
    """
    tally = Tally(len(plan), before)
    run = _Run(plan, table, setup, pool, work, report, tally, _blocks(plan, done))
    run.all()
    return tally


def _blocks(plan: Plan, done: Callable[[int], bool]) -> Iterator[list[int]]:
    """Give the numbers of trials to do, those that share a render together."""
    size = max(1, min(plan.block, MOST_IN_JOB))
    whole = max(1, plan.block)
    for first in range(0, len(plan), whole):
        for begin in range(first, min(first + whole, len(plan)), size):
            end = min(begin + size, first + whole, len(plan))
            numbers = [number for number in range(begin, end) if not done(number)]
            if numbers:
                yield numbers


class _Run:
    """A sweep at work: what is handed out, what waits, what came back."""

    def __init__(
        self,
        plan: Plan,
        table: Table,
        setup: Setup,
        pool: Pool,
        work: Work,
        report: Report,
        tally: Tally,
        blocks: Iterator[list[int]],
    ) -> None:
        self._plan, self._table, self._setup = plan, table, setup
        self._pool, self._work, self._report = pool, work, report
        self.tally = tally
        self._blocks = blocks
        self._todo: deque[list[int]] = deque()
        self._pending: dict[Future[Done], Job] = {}
        self._executor = pool.executor()
        self._numbers = itertools.count()
        self._crashes = Crashes(setup.time_limit_s)
        self._notes = _empty_folder((table.folder / NOTES).absolute())
        self._rows: list[Row] = []
        self._flushed = time.monotonic()
        self._flushes = 0
        self._trial_s: float | None = None
        self._lit: set[int] = set()
        self._light_tries: Counter[int] = Counter()
        self._form = Form(dict(plan.columns()), setup.code)

    def all(self) -> None:
        """Work until nothing is left; what goes wrong leaves the rows at hand written."""
        with counted() as presses:  # an interrupt anywhere else would tear rows at hand apart
            try:
                self._work_off(presses)
            except KeyboardInterrupt:
                self._finish_flying(presses)
                raise
            except BaseException:
                stop(self._executor)
                self._flush(0)
                raise
            self._pool.give_back(self._executor)
            self._flush(0)
            self._report(self.tally)
            shutil.rmtree(self._notes, ignore_errors=True)

    def _work_off(self, presses: Presses) -> None:
        self._hand_out()
        while self._pending:
            finished, _ = wait(self._pending, timeout=LOOK_S, return_when=FIRST_COMPLETED)
            clear_up(self._executor)
            self._take_in(finished)
            self._flush(FLUSH_S)
            self._report(self.tally)
            if presses.count:
                raise KeyboardInterrupt
            self._hand_out()

    def _finish_flying(self, presses: Presses) -> None:
        """Take in what is in flight, unless it takes long or the user insists."""
        insisting = presses.count + 1
        until = time.monotonic() + PARTING_S
        try:
            while time.monotonic() < until and presses.count < insisting:
                flying = [f for f, job in self._pending.items() if not job.only_light]
                if not flying:
                    break
                finished, _ = wait(flying, timeout=LOOK_S, return_when=FIRST_COMPLETED)
                self._take_in(finished)
        finally:
            stop(self._executor)
            self._flush(0)

    def _hand_out(self) -> None:
        """Keep the workers busy."""
        while len(self._pending) < self._pool.most_jobs:
            job = self._next()
            if job is None:
                return
            self._pending[self._executor.submit(self._work, job)] = job

    def _next(self) -> Job | None:
        """Give the next job; trials whose light is being rendered wait."""
        for _ in range(len(self._todo)):
            numbers = self._todo.popleft()
            if not self._is_dark(numbers):
                return self._job(numbers)
            self._todo.append(numbers)
        while len(self._todo) < MOST_WAITING:
            fresh = next(self._blocks, [])
            if not fresh:
                return None
            if not self._is_dark(fresh):
                return self._job(fresh)
            self._todo.append(fresh)
        return None

    def _is_dark(self, numbers: list[int]) -> bool:
        block = self._block(numbers)
        jobs = self._pending.values()
        return any(job.only_light and self._block(job.trials) == block for job in jobs)

    def _block(self, numbers: Sequence[int]) -> int:
        return numbers[0] // self._plan.block

    def _job(self, numbers: list[int]) -> Job:
        """Give the first job of some trials of a block: its light, or as many as fill some time."""
        block = self._block(numbers)
        if block not in self._lit:
            self._lit.add(block)
            self._light_tries[block] += 1
            self._todo.append(numbers)
            return Job(self._setup, (numbers[0],), only_light=True)
        size = self._size()
        if len(numbers) > size:
            self._todo.appendleft(numbers[size:])
        note = self._notes / str(next(self._numbers))
        return Job(self._setup, tuple(numbers[:size]), note=str(note))

    def _size(self) -> int:
        if self._trial_s is None:
            return FIRST_IN_JOB
        return int(min(max(JOB_S / max(self._trial_s, 1e-6), 1), MOST_IN_JOB))

    def _take_in(self, finished: Iterable[Future[Done]]) -> None:
        for future in finished:
            job = self._pending.pop(future)
            error = CancelledError() if future.cancelled() else future.exception()
            if error is None:
                self._done(job, future.result())
            elif is_crash(error):
                self.tally.crashes += 1
                self._lost(job, exit_code(self._executor, future))
            elif self._pool.local:
                raise error
            else:
                said = " ".join(f"{type(error).__name__} {error}".split())[:200]
                raise InputError(
                    f"the cluster gave up ({said})",
                    field="--scheduler",
                    remedy="see that it runs, and give the same command: it goes on",
                ) from error

    def _lost(self, job: Job, code: int | None) -> None:
        """Hand out again what a process that died was at, but not the trial that is to blame."""
        if job.only_light:
            block = self._block(job.trials)
            if self._light_tries[block] < MOST_LIGHT_TRIES:
                self._lit.discard(block)
            return
        verdict = self._crashes.judge(job.trials, read_note(job.note), code)
        self._todo.extendleft(reversed(verdict.again))
        if verdict.blamed is not None:
            number, status, reason = verdict.blamed
            trial = self._plan.trial(number)
            row = failed(trial, self._plan.key(trial), status, reason, self._form)
            self._done(job, Done([row], {}, 0.0), timed=False)

    def _done(self, job: Job, found: Done, *, timed: bool = True) -> None:
        self.tally.counts.update(found.counts)
        if job.only_light:
            self.tally.spent.add([{"render_s": found.render_s}])
            return
        if found.rest:
            self._todo.appendleft(list(found.rest))
        self._rows += found.rows
        self.tally.spent.add(found.rows)
        self.tally.done += len(found.rows)
        self.tally.failed.update(str(row["status"]) for row in found.rows if row["status"] != OK)
        if timed and found.rows:
            now = found.seconds / len(found.rows)
            self._trial_s = now if self._trial_s is None else 0.5 * (self._trial_s + now)

    def _flush(self, every_s: float) -> None:
        due = time.monotonic() - self._flushed >= every_s or len(self._rows) > FLUSH_ROWS
        if self._rows and due:
            rows, self._rows = self._rows, []
            self._table.append(rows)
            self._flushes += 1
            if self._flushes % MERGED_EVERY == 0:
                self._table.compact()
            self._flushed = time.monotonic()


def _empty_folder(folder: Path) -> Path:
    """Give an empty folder, without what a killed sweep has left in it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(exist_ok=True)
    return folder
