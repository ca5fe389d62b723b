"""All cases in their order, and running them in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from simtip.detect.contract.absences import ABSENCE_CASES
from simtip.detect.contract.borders import BORDER_CASES
from simtip.detect.contract.case import Case
from simtip.detect.contract.manners import MANNERS_CASES
from simtip.detect.contract.needles import NEEDLE_CASES
from simtip.detect.contract.probe import Probe
from simtip.detect.contract.report import CaseResult
from simtip.detect.protocol import ConfiguredDetector

CASES: tuple[Case, ...] = (*NEEDLE_CASES, *BORDER_CASES, *ABSENCE_CASES, *MANNERS_CASES)


def run_cases(
    detector: ConfiguredDetector,
    *,
    first: int = 0,
    before: Callable[[], None] = lambda: None,
) -> Iterator[CaseResult]:
    """Run the cases here, with no limit of time, and give each result as it comes.

    Parameters
    ----------
    detector
        With its parameters chosen.
    first
        Index of the first case to run.
    before
        Called before each image that is shown.
    """
    probe = Probe(detector, before)
    for case in CASES[first:]:
        yield case.result(probe)
