"""Worker processes of this machine, each alone: one that dies takes its own job with it, no other.

The standard library's pool of processes breaks as a whole when one of them dies. Here every process
is a pool of its own.
"""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

from simtip.sweep.leaving import run_until_told

P = ParamSpec("P")
T = TypeVar("T")

RECYCLED_AFTER = 500
"""Jobs of a process, after which it makes way for a new one: no leak lasts."""

JOIN_S, PARTING_S = 5.0, 1.0


class Processes(Executor):
    """Spawned processes, made when they are needed and anew when they have died.

    Parameters
    ----------
    workers
        How many.
    """

    def __init__(self, workers: int) -> None:
        self._lanes = [_Lane() for _ in range(workers)]
        self._process: WeakKeyDictionary[Future[Any], Any] = WeakKeyDictionary()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Let the process with the fewest jobs do one."""
        lane = min(self._lanes, key=lambda one: one.jobs)
        future: Future[T] = lane.submit(fn, *args, **kwargs)
        self._process[future] = lane.process
        return future

    def exit_code(self, future: Future[Any]) -> int | None:
        """Give how the process of a job that died has ended, below 0 by which signal."""
        process = self._process.get(future)
        if process is None:
            return None
        # Two threads wait for it; the one that comes second learns the code a moment later.
        until = time.monotonic() + JOIN_S
        while process.exitcode is None and time.monotonic() < until:
            time.sleep(0.005)
        code: int | None = process.exitcode
        return code

    def clear_up(self) -> None:
        """End what processes that died have left behind.

        A child that a detector forked keeps its parent's end from being noticed.
        """
        for lane in self._lanes:
            if lane.jobs and lane.process is not None and not lane.process.is_alive():
                _kill_group(lane.process.pid)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the processes end what they are at, and then themselves."""
        for lane in self._lanes:
            lane.close(wait=wait, cancel=cancel_futures)

    def kill(self) -> None:
        """End the processes: what they are at gets a moment to end what it has started."""
        for lane in self._lanes:
            lane.look()  # one may just have been begun when an interrupt came
        busy = [lane.process for lane in self._lanes if lane.jobs and lane.process is not None]
        idle = [lane.process for lane in self._lanes if not lane.jobs and lane.process is not None]
        self.shutdown(wait=False, cancel_futures=True)
        for process in busy:
            process.terminate()
        until = time.monotonic() + PARTING_S
        while time.monotonic() < until and any(process.is_alive() for process in busy):
            time.sleep(0.01)
        for process in (*busy, *idle):
            process.kill()
            _kill_group(process.pid)


class _Lane:
    """One process and what it has to do."""

    def __init__(self) -> None:
        self._executor: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._handed_out = 0
        self.jobs = 0
        self.process: Any = None

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        if self._handed_out >= RECYCLED_AFTER and not self.jobs:
            self.close(wait=False, cancel=False)
        try:
            future = self._handed_over(fn, *args, **kwargs)
        except BrokenExecutor:
            self.close(wait=False, cancel=True)
            future = self._handed_over(fn, *args, **kwargs)
        with self._lock:
            self.jobs += 1
        self._handed_out += 1
        future.add_done_callback(self._ended)
        self.look()
        return future

    def look(self) -> None:
        """Take note of the process that there is now."""
        # Private, but there is no other way to learn which process it is.
        self.process = next(
            iter((getattr(self._executor, "_processes", None) or {}).values()), None
        )

    def _handed_over(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        ready = self._ready()
        with _spared():
            return ready.submit(run_until_told, fn, *args, **kwargs)

    def _ready(self) -> ProcessPoolExecutor:
        if self._executor is None:
            self._executor = ProcessPoolExecutor(
                1, mp_context=multiprocessing.get_context("spawn"), initializer=start_worker
            )
            self._handed_out = 0
        return self._executor

    def _ended(self, _: Future[Any]) -> None:
        with self._lock:
            self.jobs -= 1

    def close(self, *, wait: bool, cancel: bool) -> None:
        if self._executor is not None:
            self._executor.shutdown(wait=wait, cancel_futures=cancel)
            self._executor = self.process = None


@contextmanager
def _spared() -> Iterator[None]:
    """Let a process that is begun in the block not see Ctrl-C before it can ignore it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def start_worker() -> None:
    """Prepare a process: Ctrl-C is its parent's affair, and it does not outlive the parent.

    What it starts is in a process group of its own, so that it can be ended with it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # as programs expect it
    os.dup2(2, 1)  # what a detector prints is no result
    sys.stdout = sys.stderr
    if os.name == "posix":
        os.setpgid(0, 0)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()


def _kill_group(leader: int) -> None:
    if os.name == "posix":
        with suppress(ProcessLookupError, PermissionError):  # nobody is left
            os.killpg(leader, signal.SIGKILL)


def _follow(parent: Any) -> None:
    multiprocessing.connection.wait([parent.sentinel])
    os._exit(1)
