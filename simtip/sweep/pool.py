"""Where jobs run: processes of this machine, or a Dask cluster that the user has.

Either way it is a `concurrent.futures.Executor`, and all else does not know which.
"""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Any

from simtip.errors import InputError

CONNECT_S = 20


class Pool:
    """Makes executors: another one after a worker process has died.

    Parameters
    ----------
    workers
        Processes of this machine.
    scheduler
        Address of a Dask scheduler, e.g. ``tcp://host:8786``; None for this machine.

    Raises
    ------
    InputError
        `simtip[cluster]` is not installed, or there is no scheduler.
    """

    def __init__(self, workers: int, scheduler: str | None = None) -> None:
        self.local = scheduler is None
        self._client = None if scheduler is None else _client(scheduler)
        self.workers = workers if self._client is None else max(1, len(_workers(self._client)))

    def executor(self, workers: int | None = None) -> Executor:
        """Give a new executor; its processes ignore Ctrl-C and end with this one."""
        if self._client is not None:
            made: Executor = self._client.get_executor(pure=False, retries=0)
            return made
        return ProcessPoolExecutor(
            workers or self.workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=start_worker,
        )

    def is_crash(self, error: BaseException) -> bool:
        """Say whether an error means that a worker process has died."""
        from concurrent.futures.process import BrokenProcessPool

        return isinstance(error, BrokenProcessPool) or type(error).__name__ == "KilledWorker"

    def close(self) -> None:
        """Leave the cluster."""
        if self._client is not None:
            self._client.close()


def start_worker() -> None:
    """Prepare a process: Ctrl-C is its parent's affair, and it does not outlive the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()


def _follow(parent: Any) -> None:
    multiprocessing.connection.wait([parent.sentinel])
    os._exit(1)


def stop(executor: Executor) -> None:
    """End an executor at once, its processes with it."""
    processes = list((getattr(executor, "_processes", None) or {}).values())
    executor.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.kill()


def _client(address: str) -> Any:
    try:
        import distributed

        client: Any = distributed.Client
    except ImportError as error:
        raise InputError(
            "needs dask.distributed", field="--scheduler", remedy="pip install 'simtip[cluster]'"
        ) from error
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
