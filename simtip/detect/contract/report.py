"""What became of each case of the contract, and how it is printed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Outcome(StrEnum):
    """What became of a case."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class CaseResult:
    """One row of the report.

    Attributes
    ----------
    name
        What was asked.
    outcome
        What became of it.
    seen
        What was seen, with its numbers, in one line.
    required
        Whether the contract is broken if it failed. The others tell what a detector can do. An
        exception, a hang or an answer that is none breaks it in any case.
    """

    name: str
    outcome: Outcome
    seen: str
    required: bool = True

    @property
    def breaks(self) -> bool:
        """Whether this breaks the contract."""
        return self.required and self.outcome is Outcome.FAILED


@dataclass(frozen=True)
class ContractReport:
    """All rows about one detector.

    Attributes
    ----------
    detector
        Its name.
    results
        One a case, in the order in which they ran.
    """

    detector: str
    results: tuple[CaseResult, ...]

    @property
    def ok(self) -> bool:
        """Whether every required case passed; what is not applicable does not break it."""
        return not any(result.breaks for result in self.results)

    def result(self, name: str) -> CaseResult:
        """Give the row of that name; raise `KeyError` if there is none."""
        for result in self.results:
            if result.name == name:
                return result
        raise KeyError(name)

    def to_dict(self) -> dict[str, Any]:
        """Give plain values: the keys of ``detectors check --json``."""
        return {
            "detector": self.detector,
            "ok": self.ok,
            "cases": [
                {
                    "name": result.name,
                    "outcome": str(result.outcome),
                    "required": result.required,
                    "seen": result.seen,
                }
                for result in self.results
            ],
        }


def report_lines(report: ContractReport) -> list[str]:
    """Print a report: a line a case, and one that sums up.

    A failed case that is not required is marked ``no`` instead of ``FAILED``.
    """
    words = {Outcome.PASSED: "passed", Outcome.NOT_APPLICABLE: "-"}
    width = max((len(result.name) for result in report.results), default=0)
    lines = []
    for result in report.results:
        failed = "FAILED" if result.required else "no"
        word = words.get(result.outcome, failed)
        lines.append(f"{word:<7} {result.name:<{width}}  {result.seen}".rstrip())
    broken = sum(result.breaks for result in report.results)
    asked = sum(result.required for result in report.results)
    verdict = "keeps the contract" if report.ok else f"fails {broken} of {asked} required cases"
    return [*lines, f"{report.detector} {verdict}"]
