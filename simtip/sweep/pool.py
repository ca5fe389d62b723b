"""Where jobs run: processes of this machine, or a Dask cluster that the user has.

Either way it is a `concurrent.futures.Executor`, and all else does not know which.
"""

from __future__ import annotations

import logging
import re
from concurrent.futures import BrokenExecutor, Executor, Future
from typing import TYPE_CHECKING, Any

from simtip.errors import InputError
from simtip.sweep.processes import Processes

if TYPE_CHECKING:
    from collections.abc import Callable

    from simtip.sweep.work import Done, Job

CONNECT_S = 10
ADDRESS = re.compile(r"(?:[a-z]+://)?[^/\s]+:\d{1,5}/?")


class Pool:
    """Makes the executor of a sweep.

    Parameters
    ----------
    workers
        Processes of this machine.
    scheduler
        Address of a Dask scheduler, e.g. ``tcp://host:8786``; None for this machine.
    lasting
        Whether processes of this machine go on from one sweep to the next, until `close`.

    Attributes
    ----------
    workers
        How many there are.
    most_jobs
        To be handed out at a time: here one a worker, so that of a process that dies it is known
        which job it was; to a cluster, farther away, two.

    Raises
    ------
    InputError
        `simtip[cluster]` is not installed, or there is no scheduler.
    """

    def __init__(
        self, workers: int, scheduler: str | None = None, *, lasting: bool = False
    ) -> None:
        self.local = scheduler is None
        self._lasting = lasting
        self._client = None if scheduler is None else _client(scheduler)
        self.workers = workers if self._client is None else max(1, len(_workers(self._client)))
        self.most_jobs = self.workers if self.local else 2 * self.workers
        self._ready: Executor | None = None

    def get_ready(self, work: Callable[[Job], Done], job: Job) -> None:
        """Let processes of this machine start, and do a job that makes them ready for others."""
        if self.local and self._ready is None:
            self._ready = self.executor()
            for _ in range(self.workers):
                self._ready.submit(work, job)

    def executor(self) -> Executor:
        """Give an executor; processes of this machine ignore Ctrl-C and end with this one."""
        if self._ready is not None:
            ready, self._ready = self._ready, None
            return ready
        if self._client is not None:
            made: Executor = self._client.get_executor(pure=False, retries=0)
            return made
        return Processes(self.workers)

    def give_back(self, executor: Executor) -> None:
        """Take an executor back that is idle: for the next sweep, or to end it."""
        if self._lasting and self.local:
            self._ready = executor
        else:
            stop(executor)

    def close(self) -> None:
        """Leave the cluster, or end processes that nobody has asked for."""
        if self._ready is not None:
            stop(self._ready)
        if self._client is not None:
            self._client.close()


def is_crash(error: BaseException) -> bool:
    """Say whether an error means that a worker process has died."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"


def exit_code(executor: Executor, future: Future[Any]) -> int | None:
    """Give how the process of a job that died has ended, below 0 by which signal; None: unknown."""
    return executor.exit_code(future) if isinstance(executor, Processes) else None


def clear_up(executor: Executor) -> None:
    """End what processes of this machine that died have left behind."""
    if isinstance(executor, Processes):
        executor.clear_up()


def stop(executor: Executor) -> None:
    """End an executor at once, its processes with it."""
    if isinstance(executor, Processes):
        executor.kill()
    else:
        executor.shutdown(wait=False)  # which cancels, at Dask


def _client(address: str) -> Any:
    if ADDRESS.fullmatch(address) is None:
        raise InputError(
            f"{address[:100]!r} is no address",
            field="--scheduler",
            remedy="write e.g. tcp://host:8786",
        )
    try:
        import distributed

        client: Any = distributed.Client
    except ImportError as error:
        raise InputError(
            "needs dask.distributed", field="--scheduler", remedy="pip install 'simtip[cluster]'"
        ) from error
    for name in list(logging.root.manager.loggerDict):
        # What goes wrong is said in our words, in one line.
        if name.startswith(("distributed", "tornado")):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        said = " ".join(str(error).split())[:200]
        raise InputError(
            f"no scheduler answers at {address} ({said})",
            field="--scheduler",
            remedy="start one with `dask scheduler`, or leave --scheduler out",
        ) from error


def _workers(client: Any) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found
