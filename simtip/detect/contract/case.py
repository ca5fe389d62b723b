"""A case of the contract: a question with its verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from simtip.detect.contract.probe import FaultError, Probe
from simtip.detect.contract.report import CaseResult, Outcome


@dataclass(frozen=True)
class Verdict:
    """Whether a case is passed, and what was seen, in one line."""

    passed: bool
    seen: str


class NotApplicableError(Exception):
    """The case asks for what this detector cannot show; the text says why."""


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes
    ----------
    name
        What is asked.
    judge
        Asks and judges. It may raise `FaultError` or `NotApplicableError`.
    required
        See `CaseResult.required`.
    """

    name: str
    judge: Callable[[Probe], Verdict]
    required: bool = True

    def result(self, probe: Probe) -> CaseResult:
        """Run the case; a fault breaks the contract whether the case is required or not."""
        try:
            verdict = self.judge(probe)
        except FaultError as fault:
            return CaseResult(self.name, Outcome.FAILED, str(fault))
        except NotApplicableError as reason:
            return CaseResult(self.name, Outcome.NOT_APPLICABLE, str(reason), self.required)
        outcome = Outcome.PASSED if verdict.passed else Outcome.FAILED
        return CaseResult(self.name, outcome, verdict.seen, self.required)
