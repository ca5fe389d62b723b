"""The conditions of a case: its trials, grouped by all that varies but the repeat."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.geometry import Array
from simtip.regress.baseline import DIGITS
from simtip.regress.sample import VIEWS, Sample
from simtip.sweep.compact import compact
from simtip.sweep.plan import Plan
from simtip.sweep.table import OK
from simtip.truth import scene_truth

PLAIN = "as it is"
"""Name of the only condition of a case without factors."""


@dataclass(frozen=True)
class Condition:
    """Trials that differ in their noise alone.

    Attributes
    ----------
    name
        The factors' values in words; unique in its case.
    trials
        Their numbers in the plan, in order of the repeats.
    """

    name: str
    trials: tuple[int, ...]


def full_name(case: str, condition: str) -> str:
    """Name a condition in the suite."""
    return case if condition == PLAIN else f"{case}: {condition}"


def conditions_of(plan: Plan) -> tuple[Condition, ...]:
    """Group a plan's trials, in its order."""
    groups: dict[tuple[int, ...], list[int]] = {}
    inner = math.prod(plan.sizes[plan_repeat(plan) + 1 :])
    repeats = plan.spec.repeats
    for number in range(len(plan)):
        outer, rest = divmod(number, repeats * inner)
        groups.setdefault((outer, rest % inner), []).append(number)
    names = [_named(plan.trial(numbers[0]).factors) for numbers in groups.values()]
    seen: Counter[str] = Counter()
    found = []
    for name, numbers in zip(names, groups.values(), strict=True):
        seen[name] += 1
        own = name if seen[name] == 1 else f"{name} ({seen[name]})"
        found.append(Condition(own, tuple(numbers)))
    return tuple(found)


def plan_repeat(plan: Plan) -> int:
    """Give which digit of a trial's number is the repeat."""
    return 1 if plan.sampled is not None else len(plan.rendered) + len(plan.mixed)


def sample_of(plan: Plan, condition: Condition, rows: Mapping[int, Mapping[str, Any]]) -> Sample:
    """Give what a table's rows say of a condition.

    Parameters
    ----------
    plan, condition
        Which trials.
    rows
        By the trial's number.
    """
    trials = [rows[number] for number in condition.trials]
    found = np.array([row["status"] == OK for row in trials], dtype=np.bool_)
    errors = np.full((len(trials), 2, 2), np.nan)
    for k, row in enumerate(trials):
        for view, side in enumerate(VIEWS):
            values = [row[f"{side}_error_{axis}_px"] for axis in "uv"]
            if None not in values:
                # As a baseline keeps them, so that equal ones are equal; without a zero's sign.
                errors[k, view] = np.round(values, DIGITS) + 0.0
    scene = plan.scenes.with_values(plan.trial(condition.trials[0]).values)
    truth = scene_truth(scene)
    axes: Array = np.round([truth.left.axis_px, truth.right.axis_px], 6)
    left, right = (
        bool(camera.contains(view.tip_px))
        for camera, view in ((truth.rig.left, truth.left), (truth.rig.right, truth.right))
    )
    return Sample(found, errors, axes + 0.0, (left, right))


def _named(factors: Mapping[str, Any]) -> str:
    parts = [f"{path}={_brief(value)}" for path, value in factors.items()]
    return ", ".join(parts) or PLAIN


def _brief(value: Any) -> str:
    text = compact(json.dumps(value)) if isinstance(value, dict | list) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
