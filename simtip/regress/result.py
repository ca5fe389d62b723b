"""A check as plain data: what ``check --json`` prints and ``regress.json`` holds."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from simtip.output_folder import write_atomically
from simtip.regress.change import BETTER, MOVED, SAME, UNTOLD, WORSE
from simtip.regress.check import Outcome, Seen
from simtip.regress.compared import LEVEL, detection_level
from simtip.regress.power import power_of_all, power_of_condition

RESULT = "regress.json"


def result_of(outcome: Outcome, baseline: Path) -> dict[str, Any]:
    """Give a check as plain data.

    Parameters
    ----------
    outcome
        The check.
    baseline
        File it was held to.
    """
    compared, recorded = outcome.compared, outcome.baseline
    trials = [len(one.now.found) for one in outcome.seen if one.now is not None]
    others = max(len(compared.pooled) - 2, 1)
    usual = min(trials, default=0)
    detection = detection_level(paired=compared.paired)
    return {
        "verdict": outcome.verdict,
        "exit_code": outcome.exit_code,
        "baseline": str(baseline),
        "suite": outcome.suite,
        "detector": {
            "before": recorded.detector.model_dump(mode="json"),
            "after": outcome.detector.reference.model_dump(mode="json"),
        },
        "comparison": _comparison(outcome),
        "seed": outcome.seed,
        "changes": [line.to_dict() for line in outcome.lines],
        "notes": list(outcome.notes),
        "counts": _counts(outcome),
        "conditions": [_condition(outcome, one) for one in outcome.seen],
        "pooled": {
            "tests": [one.to_dict() for one in compared.pooled],
            # With fresh noise, also where this check was of the same images.
            "power": power_of_all(
                usual, len(compared.conditions), others, LEVEL, detection_level(paired=False)
            ),
        },
        "time": None if outcome.time is None else outcome.time.to_dict(),
        "statistics": {
            "levels": {
                "detection": detection,
                "outliers": LEVEL,
                "shifts_and_spreads": LEVEL,
                "each_condition": LEVEL,
            },
            "false_alarm_rate": detection + 3 * LEVEL,
            "tests_of_conditions": compared.tests,
            "tolerance": recorded.tolerance.model_dump(mode="json"),
        },
        "made_with": {"before": recorded.made_with, "after": outcome.versions},
        "accepted": [one.model_dump(mode="json") for one in recorded.accepted],
    }


def write_result(folder: Path, result: dict[str, Any]) -> None:
    """Write ``regress.json``.

    Raises
    ------
    InputError
        It cannot be written.
    """
    write_atomically(folder / RESULT, (json.dumps(result, indent=1) + "\n").encode())


def _comparison(outcome: Outcome) -> str:
    if not outcome.compared.conditions:
        return "nothing"
    return "same images" if outcome.compared.paired else "fresh noise"


def _counts(outcome: Outcome) -> dict[str, int]:
    states = [_state(outcome, one) for one in outcome.seen]
    return {state: states.count(state) for state in (WORSE, UNTOLD, MOVED, BETTER, SAME)}


def _state(outcome: Outcome, one: Seen) -> str:
    return UNTOLD if one.cause is not None else outcome.state_of(one.name)


def _condition(outcome: Outcome, one: Seen) -> dict[str, Any]:
    tests: Sequence[Any] = outcome.compared.conditions.get(one.name, ())
    trials = min(len(side.found) for side in (one.before, one.now) if side is not None)
    tested = outcome.compared.tests
    return {
        "name": one.name,
        "case": one.case,
        "condition": one.condition,
        "state": _state(outcome, one),
        "cause": one.cause,
        "before": None if one.before is None else one.before.model_dump(mode="json"),
        "after": None if one.now is None else one.now.model_dump(mode="json"),
        "tests": [test.to_dict() for test in tests],
        "power": power_of_condition(trials, tested, LEVEL) if tests else None,
    }
