"""Makes the pairs of a session: once, then they are in the cache that sweeps use, too."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from simtip.errors import InputError
from simtip.pytest_plugin.options import chosen, chosen_seed
from simtip.pytest_plugin.stashed import WORKSHOP
from simtip.render import choose
from simtip.sweep.cache import Cache, default_folder
from simtip.sweep.campaign import USUAL_LIMIT_S, cores
from simtip.sweep.limit import Limit
from simtip.sweep.plan import Plan, Trial
from simtip.sweep.shots import Shot
from simtip.sweep.sizes import USUAL_SIZE, parse_size
from simtip.sweep.stages import Setting, Stages

WORKERS_VARIABLE = "PYTEST_XDIST_WORKER_COUNT"


class Workshop:
    """Makes pairs.

    Parameters
    ----------
    backend
        What renders; None is the best there is.
    cache
        Folder of renders and images; None is the user's own.
    seed
        In place of every seed of the noise that is not given; None leaves them as they are.

    Raises
    ------
    InputError
        There is no such back end, or the cache cannot be used.
    BackendError
        The back end does not work here.
    """

    def __init__(self, backend: str | None, cache: Path | None, seed: int | None) -> None:
        self.seed = seed
        self._backend = choose(backend)
        limit = parse_size(USUAL_SIZE)
        self._cache = Cache(default_folder() if cache is None else cache, limit)
        if cache is not None:
            self._cache.check()
        self._plan: Plan | None = None
        self._stages: Stages | None = None

    def make(self, plan: Plan, trial: Trial) -> tuple[Setting, Shot]:
        """Give what is true of a trial, and its images.

        Raises
        ------
        InputError
            There is no such scene.
        BackendError
            It cannot be rendered here.
        """
        if self._stages is None or self._plan is not plan:
            self._plan = plan
            self._stages = Stages(
                plan, self._cache, self._backend, Limit(USUAL_LIMIT_S), threads=_threads()
            )
        return self._stages.setting(trial), self._stages.shot(trial)


def workshop_of(config: pytest.Config) -> Workshop:
    """Give the session's; errors are those of `Workshop`."""
    if WORKSHOP not in config.stash:
        folder = chosen(config, "--simtip-cache")
        cache = None if folder is None else config.invocation_params.dir / folder
        backend = chosen(config, "--simtip-backend")
        try:
            config.stash[WORKSHOP] = Workshop(backend, cache, chosen_seed(config))
        except InputError as error:
            if error.field != "--backend":
                raise
            raise InputError(
                error.problem, field="--simtip-backend", remedy=error.remedy
            ) from error
    return config.stash[WORKSHOP]


def _threads() -> int | None:
    """Give how many threads a render may use: pytest-xdist's workers share the machine."""
    workers = os.environ.get(WORKERS_VARIABLE, "")
    return max(1, cores() // int(workers)) if workers.isdigit() and int(workers) > 1 else None
