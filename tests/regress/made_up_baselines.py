"""Baselines and results that nothing was rendered for."""

from __future__ import annotations

import numpy as np

from simtip.regress.baseline import (
    Baseline,
    CaseResult,
    ConditionResult,
    DetectorReference,
    SuiteReference,
    TimedCondition,
    ViewResult,
)
from simtip.regress.tolerance import Tolerance


def view(values: np.ndarray) -> ViewResult:
    u, v = ([None if np.isnan(x) else float(x) for x in column] for column in values.T)
    return ViewResult(
        axis=[0.0, -1.0], u=u, v=v, bias=[8.0, 0.5], sd=[0.1, 0.1], tolerance=[0.05, 0.05]
    )


def condition(name: str = "as it is", trials: int = 12, images: str = "a") -> ConditionResult:
    errors = np.round(np.random.default_rng(1).normal(0, 0.1, (trials, 2)), 4) + 0.0
    errors[0] = [0.5, -8.25]
    return ConditionResult(
        condition=name,
        found="1" * trials,
        failed={},
        images=images * 64,
        left=view(errors),
        right=view(errors),
    )


def baseline(trials: int = 12, conditions: int = 1) -> Baseline:
    return Baseline(
        suite=SuiteReference(name="made up", file="suite.yaml", sha256="b" * 64),
        detector=DetectorReference(name=None),
        made_with={"simtip": "0.1.0", "renderer": "llvm_ad_rgb", "platform": "here"},
        tolerance=Tolerance(),
        time=[TimedCondition(case="nominal", condition="as it is", ratio=0.5, scatter=0.02)],
        cases=[
            CaseResult(
                case="nominal",
                scene="c" * 64,
                levels="d" * 64,
                light_seed=1,
                noise_seed=1,
                detector="lin2020",
                conditions=[
                    condition("as it is" if k == 0 else f"level {k}", trials)
                    for k in range(conditions)
                ],
            )
        ],
    )
