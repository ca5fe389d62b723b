"""Record a baseline, and accept changes of it case by case."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from pathlib import Path

from simtip.errors import InputError
from simtip.regress.baseline import Accepted, Baseline, TimedCondition
from simtip.regress.check import Outcome
from simtip.regress.chosen import Chosen
from simtip.regress.performed import Observed, Planned, Said, perform, planned
from simtip.regress.recorded import case_result, suite_reference, timed, versions_now
from simtip.regress.suite import Suite
from simtip.regress.timing import Asked, time_in_worker, timed_conditions
from simtip.sweep.campaign import Means
from simtip.sweep.pool import Pool


def record(
    suite: Suite,
    detector: Chosen,
    file: Path,
    folder: Path,
    means: Means,
    *,
    seed: int | None = None,
    said: Said = lambda _: None,
) -> Baseline:
    """Work a suite out, and give what a baseline keeps of it.

    Parameters
    ----------
    suite
        What is tried.
    detector
        In place of the scenes' own.
    file
        Where the baseline will be.
    folder
        Of the sweeps.
    means
        What works on it.
    seed
        Of the noise, in place of the suite's.
    said
        Told what is begun.

    Raises
    ------
    InputError
        Something does not fit, or no tip at all was found.
    """
    cases = planned(suite.cases, detector, means, seed)
    pool = Pool(means.local_workers, lasting=True)
    try:
        observed = perform(cases, folder, means, pool, said)
        _require_tips(observed, suite)
        said("timing the detector")
        times = _times(cases, observed, pool)
    finally:
        pool.close()
    tolerance = suite.spec.tolerance
    return Baseline(
        suite=suite_reference(suite, file),
        detector=detector.reference,
        seed=seed,
        made_with=versions_now(means.backend),
        tolerance=tolerance,
        time=times,
        cases=[
            case_result(one, found, tolerance, None)
            for one, found in zip(cases, observed, strict=True)
        ],
    )


def _require_tips(observed: Sequence[Sequence[Observed]], suite: Suite) -> None:
    if not any(one.sample.found.any() for conditions in observed for one in conditions):
        failed = [status for found in observed for one in found for status in one.failed]
        raise InputError(
            f"no tip was found in any of {len(failed)} conditions ({failed[0]})",
            file=suite.document.file,
            remedy="there is nothing to hold a detector to: see that it works on some",
        )


def _times(
    cases: Sequence[Planned], observed: Sequence[Sequence[Observed]], pool: Pool
) -> list[TimedCondition]:
    found = []
    for place, k in timed_conditions(observed):
        case, one = cases[place], observed[place][k]
        trial = one.condition.trials[0]
        ratio = time_in_worker(pool, Asked(case.setup, trial))
        if ratio is not None:
            found.append(timed(case, one, ratio))
    return found


def updated(
    baseline: Baseline,
    outcome: Outcome,
    suite: Suite,
    file: Path,
    names: Sequence[str] | None,
    reason: str,
) -> Baseline:
    """Give a baseline with the results of some cases replaced.

    Parameters
    ----------
    baseline
        As it was.
    outcome
        Of a check of those cases.
    suite
        As it is now.
    file
        The baseline's.
    names
        Of the cases; None is all, and cases that the suite no longer has are dropped.
    reason
        Kept with each.

    Raises
    ------
    InputError
        Of all cases no tip at all was found.
    """
    if names is None:
        _require_tips(outcome.observed, suite)
    today = dt.datetime.now(dt.UTC).date().isoformat()
    versions = outcome.versions
    old = {one.case: one for one in baseline.cases}
    everything = names is None
    new = {
        case.name: case_result(
            case,
            found,
            suite.spec.tolerance,
            None if everything or versions == baseline.made_with else versions,
        )
        for case, found in zip(outcome.cases, outcome.observed, strict=True)
    }
    order = [case.name for case in suite.cases]
    if not everything:
        order += [name for name in old if name not in order]
    kept = [new.get(name) or old[name] for name in order if name in new or name in old]
    accepted = [
        Accepted(case=name, date=today, reason=reason, changes=outcome.changes_of(name))
        for name in new
    ]
    times = {(one.case, one.condition): one for one in baseline.time}
    times |= {key: one for key, one in outcome.times_now.items() if everything or key[0] in new}
    return baseline.model_copy(
        update={
            "suite": suite_reference(suite, file),
            "detector": outcome.detector.reference,
            "made_with": versions if everything else baseline.made_with,
            "tolerance": suite.spec.tolerance,
            "accepted": [*baseline.accepted, *accepted],
            "time": [one for one in times.values() if one.case in {c.case for c in kept}],
            "cases": kept,
        }
    )
