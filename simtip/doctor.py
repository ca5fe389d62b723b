"""What `simtip doctor` finds: which renderers work here, which is used, how to mend the rest."""

from __future__ import annotations

import os
import platform
import sys
from dataclasses import dataclass
from typing import Any

from simtip.errors import BackendError
from simtip.render.backend import Backend, Verdict, choose, judge, try_backend, try_cuda
from simtip.render.libllvm import WHEEL, Candidate, candidates


@dataclass(frozen=True)
class Diagnosis:
    """The state of this machine.

    Attributes
    ----------
    cuda
        Whether a GPU can be used.
    llvm
        Every LLVM library found, with its verdict.
    backend
        What is used, or None if even that fails.
    trial
        Whether a trial picture came out right on it.
    problem
        Why there is no back end, if there is none.
    advice
        What to do, best first; empty when all is well.
    """

    cuda: Verdict
    llvm: tuple[tuple[Candidate, Verdict], ...]
    backend: Backend | None
    trial: Verdict
    problem: str
    advice: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether simtip can render here."""
        return self.backend is not None and self.trial.ok

    def to_dict(self) -> dict[str, Any]:
        """Give plain data: the keys of ``doctor --json``."""
        backend = self.backend
        return {
            "ok": self.ok,
            "backend": backend
            and {
                "name": backend.name,
                "variant": backend.variant,
                "reason": backend.reason,
                "libllvm": backend.libllvm,
            },
            "trial": self.trial.detail,
            "problem": self.problem,
            "cuda": {"ok": self.cuda.ok, "detail": self.cuda.detail},
            "llvm": [
                {
                    "path": candidate.path,
                    "source": candidate.source,
                    "version": candidate.version,
                    "ok": verdict.ok,
                    "detail": verdict.detail,
                }
                for candidate, verdict in self.llvm
            ],
            "cores": os.cpu_count(),
            "advice": list(self.advice),
        }


def diagnose(wanted: str | None = None) -> Diagnosis:
    """Try everything that could render, each in a process of its own.

    Parameters
    ----------
    wanted
        A back end to insist on; see `simtip.render.choose`.

    Raises
    ------
    InputError
        There is no back end of that name.
    """
    backend, problem = None, ""
    try:
        backend = choose(wanted)
    except BackendError as error:
        problem = str(error)
    cuda = try_cuda()
    llvm = tuple((candidate, judge(candidate)) for candidate in candidates())
    trial = try_backend(backend) if backend else Verdict(ok=False, detail="not tried")
    works = any(verdict.ok for _, verdict in llvm)
    advice = () if cuda.ok or works else how_to_get_llvm()
    return Diagnosis(cuda, llvm, backend, trial, problem, advice)


def how_to_get_llvm(system: str = sys.platform, machine: str | None = None) -> tuple[str, ...]:
    """Say how to get an LLVM library on a system."""
    machine = machine or platform.machine()
    by_hand = "if it is not found, set DRJIT_LIBLLVM_PATH to the library's path"
    if system == "linux" and machine == "x86_64":
        return (f"pip install '{WHEEL}>=19.1.7,<24'",)
    if system == "darwin":
        return ("brew install llvm", by_hand)
    if system == "win32":
        return ("winget install LLVM.LLVM", by_hand)
    return ("install LLVM 19 or newer, e.g. apt install llvm-19 or dnf install llvm-libs", by_hand)
