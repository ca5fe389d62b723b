"""What was worked out, as a baseline keeps it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from simtip.geometry import Array
from simtip.provenance import environment
from simtip.regress.baseline import (
    DIGITS,
    CaseResult,
    ConditionResult,
    SuiteReference,
    TimedCondition,
    Versions,
    ViewResult,
)
from simtip.regress.performed import Observed, Planned, levels_digest, scene_digest
from simtip.regress.quantities import deviation
from simtip.regress.suite import STANDARD, Suite, standard_suite
from simtip.regress.timing import Ratio
from simtip.regress.tolerance import Tolerance
from simtip.render import choose
from simtip.sweep.stage_keys import digest_of


def versions_now(backend: str | None) -> Versions:
    """Name what images and measurements depend on, besides the scene."""
    facts = environment()
    return {
        "simtip": facts["simtip"],
        "renderer": choose(backend).variant,
        "python": facts["python"],
        "platform": facts["platform"],
        **facts["packages"],
    }


def suite_reference(suite: Suite, baseline: Path) -> SuiteReference:
    """Name a suite so that the baseline finds it: the standard one, or by the way to its file."""
    path = Path(suite.document.file)
    if path.resolve() == standard_suite().resolve():
        file = STANDARD
    else:
        folder = Path(os.path.realpath(baseline)).parent
        file = Path(os.path.relpath(os.path.realpath(path), folder)).as_posix()
    return SuiteReference(name=suite.name, file=file, sha256=suite_digest(suite))


def suite_digest(suite: Suite) -> str:
    """Tell what a suite's file says from any other's; its comments and layout do not count."""
    return digest_of(suite.document.value)


def suite_of(reference: SuiteReference, baseline: Path) -> str | Path:
    """Give the suite's file that a baseline names."""
    if reference.file == STANDARD:
        return standard_suite()
    return Path(os.path.realpath(baseline)).parent / reference.file


def case_result(
    case: Planned, observed: Sequence[Observed], tolerance: Tolerance, made_with: Versions | None
) -> CaseResult:
    """Give a case as a baseline keeps it."""
    return CaseResult(
        case=case.name,
        scene=scene_digest(case.plan),
        levels=levels_digest(case.plan),
        light_seed=case.plan.base.seed,
        noise_seed=case.plan.seed,
        detector=case.plan.detectors[0].reference,
        made_with=made_with,
        conditions=[_condition(one, tolerance) for one in observed],
    )


def timed(case: Planned, observed: Observed, ratio: Ratio) -> TimedCondition:
    """Give a time as a baseline keeps it."""
    return TimedCondition(
        case=case.name,
        condition=observed.condition.name,
        ratio=_digits(ratio.ratio),
        scatter=_digits(ratio.scatter),
    )


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


def _condition(one: Observed, tolerance: Tolerance) -> ConditionResult:
    left, right = (_view(one, view, tolerance) for view in range(2))
    return ConditionResult(
        condition=one.condition.name,
        found="".join("1" if found else "0" for found in one.sample.found),
        failed=dict(sorted(one.failed.items())),
        images=one.images,
        left=left,
        right=right,
    )


def _view(one: Observed, view: int, tolerance: Tolerance) -> ViewResult:
    errors = one.sample.error_px[:, view]
    needle = one.sample.needle_px[one.sample.seen(view), view]
    few = len(needle) < 2
    sd = [] if few else [deviation(needle[:, axis]) for axis in range(2)]
    least = [max(tolerance.bias_px, tolerance.bias_sigma * one) for one in sd]
    return ViewResult(
        axis=one.sample.axis_px[view].tolist(),
        u=_errors(errors[:, 0]),
        v=_errors(errors[:, 1]),
        bias=None if few else _rounded(needle.mean(axis=0).tolist()),
        sd=None if few else _rounded(sd),
        tolerance=None if few else _rounded(least),
    )


def _errors(values: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


def _rounded(values: Sequence[float]) -> list[float]:
    return [round(value, DIGITS) + 0.0 for value in values]
