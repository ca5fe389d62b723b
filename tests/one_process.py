"""The command line with the jobs of its worker processes done in this one.

What a sweep does with its jobs is the same; what is left out is the time that processes take to
start and to load a renderer.
"""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any
from unittest import mock

import pytest
from asked import Answer, call

from simtip.detect import process
from simtip.sweep import stage_keys, work


class Here(Executor):
    """Stands in for `simtip.sweep.processes.Processes`: does a job when it is handed out."""

    def __init__(self, workers: int) -> None:
        assert workers > 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do a job, which comes and goes as data, as it does between processes."""
        future: Future[Any] = Future()
        told, words, named = pickle.loads(pickle.dumps((fn, args, kwargs)))  # noqa: S301
        try:
            future.set_result(pickle.loads(pickle.dumps(told(*words, **named))))  # noqa: S301
        except Exception as error:  # noqa: BLE001 (the caller's, as of any executor)
            future.set_exception(error)
        return future

    def exit_code(self, _: Future[Any]) -> None:
        """Nothing has ended."""

    def clear_up(self) -> None:
        """Nothing is left behind."""

    def kill(self) -> None:
        """Nothing is at work."""


@contextmanager
def workers_here() -> Iterator[None]:
    """Let workers be this process, new and without a memory, which stays as it was."""
    work.workshop.cache_clear()
    stage_keys.detector_code.cache_clear()
    with pytest.MonkeyPatch.context() as patch, mock.patch.dict(os.environ):
        patch.setattr("simtip.sweep.pool.Processes", Here)
        patch.setattr(work, "use_threads", lambda _: None)
        patch.setattr(process, "LONGEST_S", process.LONGEST_S)
        yield
    work.workshop.cache_clear()


def call_here(*words: object, **environment: str) -> Answer:
    """Call the command line, workers and all, in this process."""
    with workers_here(), mock.patch.dict(os.environ, {"SIMTIP_BACKEND": "llvm", **environment}):
        return call(*map(str, words))
