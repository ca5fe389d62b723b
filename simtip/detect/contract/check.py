"""The contract run in a process of its own: a detector that hangs or crashes is a result."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler

from simtip.detect import registry
from simtip.detect.contract.cases import CASES, run_cases
from simtip.detect.contract.report import CaseResult, ContractReport, Outcome
from simtip.detect.protocol import Detector
from simtip.errors import InputError

LIMIT_S = 90.0
"""For one image; more than an external command may take by default."""
START_S = 90.0
"""For the process to start and import what the detector needs."""
MAX_LOST = 2
"""After so many processes that hung or died the rest is not tried."""

READY, ASKED, RESULT, UNUSABLE = "ready", "asked", "result", "unusable"
Message = tuple[str, object]


def check(
    detector: Detector | str,
    values: Mapping[str, object] | None = None,
    *,
    limit_s: float = LIMIT_S,
    progress: Callable[[float], None] = lambda _share: None,
) -> ContractReport:
    """Run a detector through all cases of the contract.

    Parameters
    ----------
    detector
        As `simtip.detect.get` takes it, which the other process finds for itself; or an object,
        which is sent there and so has to be made of things that a module holds under their names.
    values
        Its parameters; what is absent keeps its default.
    limit_s
        Time for one image, s. A detector that takes longer is stopped.
    progress
        Told the share of the cases that is done.

    Raises
    ------
    InputError
        There is no such detector, it cannot be configured so, or it cannot be sent to another
        process.
    """
    name = detector if isinstance(detector, str) else detector.name
    _check_sendable(detector, name)
    results: list[CaseResult] = []

    def add(result: CaseResult) -> None:
        results.append(result)
        progress(len(results) / len(CASES))

    lost = 0
    while len(results) < len(CASES):
        if lost == MAX_LOST:
            results += [_not_tried(case.name, case.required) for case in CASES[len(results) :]]
            break
        lost += _run(detector, values or {}, len(results), limit_s, add)
    return ContractReport(name, tuple(results))


def _check_sendable(detector: Detector | str, name: str) -> None:
    try:
        ForkingPickler.dumps(detector)
    except Exception as error:  # any object may refuse in its own way
        raise InputError(
            f"the detector {name} cannot be sent to another process ({error})",
            remedy="define its function at the top of a module, or give its name",
        ) from error


def _not_tried(name: str, required: bool) -> CaseResult:
    text = f"not tried: its process was lost {MAX_LOST} times"
    return CaseResult(name, Outcome.NOT_APPLICABLE, text, required)


def _run(
    detector: Detector | str,
    values: Mapping[str, object],
    first: int,
    limit_s: float,
    add: Callable[[CaseResult], None],
) -> bool:
    """Run the cases from one on, and say whether the process was lost before the last."""
    context = multiprocessing.get_context("spawn")  # a fork would share what a renderer started
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(
        target=_work, args=(theirs, detector, dict(values), first), daemon=True
    )
    process.start()
    theirs.close()
    index, started = first, False
    try:
        while index < len(CASES):
            patience_s = limit_s if started else max(limit_s, START_S)
            if not ours.poll(patience_s):
                add(_lost(index, f"no answer within {patience_s:g} s"))
                return True
            kind, content = ours.recv()
            if kind == UNUSABLE:
                raise InputError(str(content))
            started = True
            if kind == RESULT:
                add(content)
                index += 1
    except EOFError:
        process.join()
        how = _ending(process.exitcode)
        if not started:
            raise InputError(f"the process for the detector {how}") from None
        add(_lost(index, f"its process {how}"))
        return True
    finally:
        process.kill()
        process.join()
        ours.close()
    return False


def _lost(index: int, how: str) -> CaseResult:
    return CaseResult(CASES[index].name, Outcome.FAILED, how)


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        return f"was ended by signal {-code}"
    return f"ended with exit code {code}"


def _work(
    connection: Connection, detector: Detector | str, values: Mapping[str, object], first: int
) -> None:
    """Run the cases in the other process, and tell each step."""
    # what a detector prints must not get among what the caller prints
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        found = registry.get(detector) if isinstance(detector, str) else detector
        configured = found.configure(values)
    except InputError as error:
        connection.send((UNUSABLE, str(error)))
        return
    connection.send((READY, None))
    for result in run_cases(configured, first=first, before=lambda: connection.send((ASKED, None))):
        connection.send((RESULT, result))
