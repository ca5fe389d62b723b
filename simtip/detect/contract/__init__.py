"""What every detector has to do, runnable on any of them."""

from simtip.detect.contract.cases import CASES, run_cases
from simtip.detect.contract.check import check
from simtip.detect.contract.report import CaseResult, ContractReport, Outcome, report_lines

__all__ = [
    "CASES",
    "CaseResult",
    "ContractReport",
    "Outcome",
    "check",
    "report_lines",
    "run_cases",
]
