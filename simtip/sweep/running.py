"""Run a sweep: hand out jobs, take in rows, go on when a worker dies.

Of every block of trials that share a render, the light comes first, once; then its trials follow in
jobs of a few seconds. Rows are written as they come. A job whose process dies is halved until the
trial is found that is to blame; that becomes a row with its reason.
"""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass, field, replace

from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool, stop
from simtip.sweep.rows import failed
from simtip.sweep.table import Table
from simtip.sweep.work import Done, Job, Row, Setup, run_job

JOB_S = 3.0
"""What a job should take."""

MOST_IN_JOB = 2000

FIRST_IN_JOB = 2
"""Trials of a job while nothing is known of how long they take."""

AHEAD = 2
"""Jobs a worker, handed out beforehand."""

FLUSH_S = 2.0
"""Rows are written so often."""

FLUSH_ROWS = 20_000

DIED = "worker_died"


@dataclass
class Tally:
    """How far a sweep is.

    Attributes
    ----------
    total, before, done
        Trials: of the plan, found done, done now.
    failed
        By status, of those done now.
    counts
        How often each stage was worked out now.
    crashes
        Worker processes that died.
    """

    total: int
    before: int = 0
    done: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    counts: Counter[str] = field(default_factory=Counter)
    crashes: int = 0
    started: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Wall time so far."""
        return time.perf_counter() - self.started


Report = Callable[[Tally], None]
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
    run = _Run(plan, table, setup, pool, work, report, Tally(len(plan), before))
    run.all(_blocks(plan, done))
    return run.tally


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


@dataclass
class _Queue:
    """Jobs to hand out: light first, then what needs it."""

    ready: deque[Job] = field(default_factory=deque)
    waiting: dict[int, list[int]] = field(default_factory=dict)


class _Run:
    def __init__(
        self,
        plan: Plan,
        table: Table,
        setup: Setup,
        pool: Pool,
        work: Work,
        report: Report,
        tally: Tally,
    ) -> None:
        self._plan, self._table, self._setup = plan, table, setup
        self._pool, self._work, self._report = pool, work, report
        self.tally = tally
        self._rows: list[Row] = []
        self._flushed = time.monotonic()
        self._trial_s: float | None = None
        self._lit: set[int] = set()
        self._kinds = dict(plan.columns())

    def all(self, blocks: Iterator[list[int]]) -> None:
        executor = self._pool.executor()
        pending: dict[Future[Done], Job] = {}
        todo: deque[list[int]] = deque()
        try:
            while True:
                executor = self._hand_out(executor, pending, todo, blocks)
                if not pending:
                    break
                finished, _ = wait(pending, timeout=1.0, return_when=FIRST_COMPLETED)
                executor = self._take_in(executor, pending, todo, finished)
                self._flush(FLUSH_S)
                self._report(self.tally)
        except BaseException:
            stop(executor)
            self._flush(0)
            raise
        executor.shutdown()
        self._flush(0)
        self._report(self.tally)

    def _hand_out(
        self,
        executor: Executor,
        pending: dict[Future[Done], Job],
        todo: deque[list[int]],
        blocks: Iterator[list[int]],
    ) -> Executor:
        while len(pending) < AHEAD * self._pool.workers:
            job = self._next(pending, todo, blocks)
            if job is None:
                break
            try:
                pending[executor.submit(self._work, job)] = job
            except RuntimeError:  # it broke meanwhile: what is pending will say so
                todo.appendleft(list(job.trials))
                break
        return executor

    def _next(
        self,
        pending: dict[Future[Done], Job],
        todo: deque[list[int]],
        blocks: Iterator[list[int]],
    ) -> Job | None:
        """Give the next job; one that needs a light which is being rendered waits."""
        dark = {job.trials[0] // self._plan.block for job in pending.values() if job.only_light}
        for _ in range(len(todo)):
            numbers = todo.popleft()
            if numbers[0] // self._plan.block in dark:
                todo.append(numbers)
                continue
            return self._job(numbers, todo)
        numbers = next(blocks, None)
        if numbers is None:
            return None
        if numbers[0] // self._plan.block in dark:
            todo.append(numbers)
            return self._next(pending, deque(), blocks) if len(todo) < 64 else None
        return self._job(numbers, todo)

    def _job(self, numbers: list[int], todo: deque[list[int]]) -> Job:
        block = numbers[0] // self._plan.block
        if block not in self._lit:
            self._lit.add(block)
            todo.append(numbers)
            return Job(self._setup, (numbers[0],), only_light=True)
        size = self._size()
        if len(numbers) > size:
            todo.appendleft(numbers[size:])
        return Job(self._setup, tuple(numbers[:size]))

    def _size(self) -> int:
        if self._trial_s is None:
            return FIRST_IN_JOB
        return int(min(max(JOB_S / max(self._trial_s, 1e-6), 1), MOST_IN_JOB))

    def _take_in(
        self,
        executor: Executor,
        pending: dict[Future[Done], Job],
        todo: deque[list[int]],
        finished: Iterable[Future[Done]],
    ) -> Executor:
        lost = []
        for future in finished:
            job = pending.pop(future)
            error = future.exception()
            if error is None:
                self._done(job, future.result())
            elif self._pool.is_crash(error):
                lost.append(job)
            else:
                raise error
        if not lost:
            return executor
        # The others of a broken pool end the same way; whose fault it is, is found out one by one.
        if self._pool.local:
            wait(pending, timeout=10.0)
            for future, job in list(pending.items()):
                if future.done() and not future.cancelled() and future.exception() is None:
                    self._done(job, future.result())
                else:
                    lost.append(job)
            pending.clear()
            stop(executor)
            executor = self._pool.executor()
        self.tally.crashes += 1
        for job in lost:
            self._in_quarantine(job)
        return executor

    def _in_quarantine(self, job: Job) -> None:
        """Work out a job in a process of its own, by halves if it dies, down to one trial."""
        halves = deque([job])
        while halves:
            part = halves.popleft()
            executor = self._pool.executor(1)
            start = time.perf_counter()
            try:
                found = executor.submit(self._work, part).result()
            except Exception as error:
                if not self._pool.is_crash(error):
                    raise
                halves.extendleft(reversed(self._parts(part, time.perf_counter() - start)))
            else:
                self._done(part, found)
            finally:
                stop(executor) if self._pool.local else executor.shutdown(wait=False)
            self._flush(FLUSH_S)
            self._report(self.tally)

    def _parts(self, job: Job, seconds: float) -> list[Job]:
        """Give the halves of a job whose process died; of one trial, none, but its row."""
        if len(job.trials) > 1:
            half = len(job.trials) // 2
            return [
                replace(job, trials=job.trials[:half]),
                replace(job, trials=job.trials[half:]),
            ]
        if job.only_light:
            return []  # its trials will find out for themselves
        trial = self._plan.trial(job.trials[0])
        limit = self._setup.time_limit_s
        reason = f"its process took longer than {limit:g} s" if seconds > limit else ""
        reason = reason or "its process died: a crash in the detector, or no memory"
        status = "timed_out" if seconds > limit else DIED
        row = failed(trial, self._plan.key(trial), status, reason, self._kinds)
        self._done(job, Done([row], {}, seconds), timed=False)
        return []

    def _done(self, job: Job, found: Done, *, timed: bool = True) -> None:
        self.tally.counts.update(found.counts)
        if job.only_light:
            return
        self._rows += found.rows
        self.tally.done += len(found.rows)
        self.tally.failed.update(str(row["status"]) for row in found.rows if row["status"] != "ok")
        if timed and found.rows:
            now = found.seconds / len(found.rows)
            self._trial_s = now if self._trial_s is None else 0.5 * (self._trial_s + now)

    def _flush(self, every_s: float) -> None:
        due = time.monotonic() - self._flushed >= every_s or len(self._rows) > FLUSH_ROWS
        if self._rows and due:
            self._table.append(self._rows)
            self._rows = []
            self._flushed = time.monotonic()
