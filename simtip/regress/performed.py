"""A suite worked out: every case a sweep, in one folder and by the same processes."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simtip.errors import InputError
from simtip.experiment.performed import make_folder
from simtip.regress.chosen import Chosen
from simtip.regress.conditions import Condition, conditions_of, full_name, sample_of
from simtip.regress.sample import Sample
from simtip.regress.suite import Case
from simtip.render import choose
from simtip.sweep.cache import Cache
from simtip.sweep.campaign import Means, carry_out, prepare
from simtip.sweep.limit import Limit
from simtip.sweep.plan import Plan
from simtip.sweep.pool import Pool
from simtip.sweep.stage_keys import digest_of
from simtip.sweep.stages import Stages
from simtip.sweep.table import OK, Table
from simtip.sweep.work import Setup

SWEEPS = "sweeps"

Said = Callable[[str], None]


@dataclass(frozen=True)
class Planned:
    """A case as it is to be worked out.

    Attributes
    ----------
    case
        Of the suite.
    plan
        Its sweep, with one detector.
    setup
        What jobs of it share.
    conditions
        Groups of its trials.
    """

    case: Case
    plan: Plan
    setup: Setup
    conditions: tuple[Condition, ...]

    @property
    def name(self) -> str:
        """The case's."""
        return self.case.name


@dataclass(frozen=True, eq=False)
class Observed:
    """A condition worked out.

    Attributes
    ----------
    condition
        Which one.
    sample
        What was found.
    failed
        Statuses of trials without a tip.
    images
        SHA-256 of all its images, None where there is none.
    detect_s
        Median time for a pair, s; None if none was measured.
    """

    condition: Condition
    sample: Sample
    failed: Mapping[str, int]
    images: str | None
    detect_s: float | None


def planned(
    cases: Sequence[Case], detector: Chosen, means: Means, seed: int | None = None
) -> list[Planned]:
    """Plan cases with a detector; nothing is worked out.

    Parameters
    ----------
    cases
        Of a suite.
    detector
        In place of each one's own.
    means
        What works on them.
    seed
        Of the noise, in place of the suite's.

    Raises
    ------
    InputError
        A case does not fit its scene, or the detector or its parameters are none.
    """
    found = []
    for case in cases:
        spec = case.sweep.spec.model_copy(
            update={
                "detectors": detector.entry(case.sweep.scene),
                **({} if seed is None else {"seed": seed}),
            }
        )
        try:
            plan = Plan(spec, case.sweep.scene, detector.allowed_names, case.name)
        except InputError as error:
            if (error.field or "").startswith("detect"):
                option = "--detector" if "name" in str(error.field) else "--detector or --set"
                raise InputError(error.problem, field=option, remedy=error.remedy) from error
            raise case.sweep.located(error) from error
        found.append(Planned(case, plan, prepare(plan, means), conditions_of(plan)))
    _require_names(found)
    return found


def _require_names(cases: Sequence[Planned]) -> None:
    """Refuse a case named as a condition of another: results would mix them up."""
    known: dict[str, str] = {}
    for case in cases:
        for one in case.conditions:
            name = full_name(case.name, one.name)
            if name in known:
                raise InputError(
                    f"a condition of {known[name]!r} and one of {case.name!r} have the same name, "
                    f"{name!r}",
                    file=case.case.sweep.document.file,
                    field="cases",
                    remedy="give one of the two cases another name",
                )
            known[name] = case.name


def perform(
    cases: Sequence[Planned], out: Path, means: Means, pool: Pool, said: Said = lambda _: None
) -> list[list[Observed]]:
    """Work cases out, or go on with them.

    Parameters
    ----------
    cases
        See `planned`.
    out
        Folder of their sweeps.
    means
        What they are worked out with.
    pool
        Of processes, for all of them.
    said
        Told what is begun.

    Returns
    -------
    observed
        Of each case the conditions.

    Raises
    ------
    InputError
        The folder cannot be written.
    KeyboardInterrupt
        The same call goes on.
    """
    make_folder(out / SWEEPS)
    found = []
    for number, one in enumerate(cases):
        said(f"{one.name}: {len(one.plan)} pairs of images ({number + 1} of {len(cases)})")
        folder = out / SWEEPS / f"{number:03d}"
        carry_out(one.plan, one.setup, folder, means, shared=pool)
        rows = Table.open(folder).by_trial()
        stages = stages_of(one)
        found.append([_observed(one, condition, rows, stages) for condition in one.conditions])
    return found


def stages_of(case: Planned) -> Stages:
    """Give what works out a case's images in this process, from the cache if they are there."""
    setup = case.setup
    cache = None if setup.cache is None else Cache(Path(setup.cache), setup.cache_bytes)
    return Stages(case.plan, cache, choose(setup.backend), Limit(setup.time_limit_s))


def scene_digest(plan: Plan) -> str:
    """Tell what a case's images show from any other's: the scene without seed and detector."""
    data = plan.base.model_dump(mode="json", exclude={"seed", "detect", "name"})
    return digest_of([data, plan.spec.render_for])


def levels_digest(plan: Plan) -> str:
    """Tell what varies in a case from any other's."""
    levels = [[list(one.paths), one.levels, repr(one.span)] for one in plan.dimensions]
    return digest_of([levels, plan.spec.design.model_dump(mode="json")])


def _observed(
    case: Planned, condition: Condition, rows: Mapping[int, Mapping[str, Any]], stages: Stages
) -> Observed:
    mine = [rows[number] for number in condition.trials]
    times = [row["detect_s"] for row in mine if row["detect_s"] is not None]
    return Observed(
        condition,
        sample_of(case.plan, condition, rows),
        Counter(str(row["status"]) for row in mine if row["status"] != OK),
        _images_digest(case.plan, condition, stages),
        float(np.median(times)) if times else None,
    )


def _images_digest(plan: Plan, condition: Condition, stages: Stages) -> str | None:
    """Give the SHA-256 of a condition's images: kind, shape and pixels, trial after trial."""
    told = hashlib.sha256()
    for number in condition.trials:
        try:
            shot = stages.shot(plan.trial(number))
        except InputError:  # its row says why
            return None
        for image in shot.images:
            told.update(f"{image.dtype.str} {image.shape}\n".encode())
            told.update(np.ascontiguousarray(image).data)
    return told.hexdigest()
