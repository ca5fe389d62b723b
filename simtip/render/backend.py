"""Choose and start a renderer back end that works on this machine.

Order: CUDA if there is a GPU, else LLVM with a library that is known to work, else scalar. A bad
LLVM (14 and 15 with Dr.Jit 1.5) aborts the process at the first kernel, which no ``except``
catches; so a library is either one of the versions that the project tested, from its own wheel, or
it is tried first in a process of its own.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from platformdirs import user_cache_path

from simtip.errors import BackendError, InputError
from simtip.render.libllvm import Candidate, candidates, resident

Name = Literal["cuda", "llvm", "scalar"]
VARIANTS: dict[Name, str] = {
    "cuda": "cuda_ad_rgb",
    "llvm": "llvm_ad_rgb",
    "scalar": "scalar_rgb",
}
PROBE_TIMEOUT_S = 120
ITS_OWN_FAULT = {signal.SIGABRT, signal.SIGILL, signal.SIGSEGV}
"""How a bad library ends its process. Other ends may lie with the machine and be mended."""
CHOICE_VARIABLE = "SIMTIP_BACKEND"
LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"


@dataclass(frozen=True)
class Backend:
    """What renders, and why it was chosen."""

    name: Name
    reason: str
    libllvm: str | None = None

    @property
    def variant(self) -> str:
        """Mitsuba's name for it."""
        return VARIANTS[self.name]


@dataclass(frozen=True)
class Verdict:
    """Whether something was found to work here.

    Attributes
    ----------
    ok, detail
        The answer and its reason.
    lasting
        Would be the same tomorrow.
    """

    ok: bool
    detail: str
    lasting: bool = True


def _probe(variant: str, environment: dict[str, str]) -> Verdict:
    """Try a variant in a child process; a crash there is an answer here."""
    try:
        done = subprocess.run(  # noqa: S603 (this interpreter, fixed arguments)
            [sys.executable, "-m", "simtip.render.probe", variant],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=PROBE_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        detail = f"the trial did not end: {type(error).__name__}"
        return Verdict(ok=False, detail=detail, lasting=False)
    if done.returncode == 0 and done.stdout.strip():
        answer = json.loads(done.stdout.strip().splitlines()[-1])
        if answer["ok"]:
            return Verdict(ok=True, detail="rendered a trial picture rightly")
        return Verdict(ok=False, detail=f"rendered a trial picture wrongly ({answer['mean']:.3f})")
    lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    telling = next((line for line in lines if "LLVM" in line or "rror" in line), "")
    how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit {done.returncode}"
    return Verdict(
        ok=False,
        detail=f"the trial process died ({how}) {telling[:160]}".strip(),
        lasting=-done.returncode in ITS_OWN_FAULT,
    )


def _memo_path() -> Path:
    return Path(user_cache_path("simtip", appauthor=False)) / "libllvm-trials.json"


def _recall(path: Path) -> dict[str, Any]:
    try:
        memo = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return memo if isinstance(memo, dict) else {}


def try_llvm(path: str) -> Verdict:
    """Try an LLVM library in a child process; remembered until the file or Dr.Jit changes."""
    try:
        stat = Path(path).stat()
    except OSError as error:
        return Verdict(ok=False, detail=f"cannot be read: {error.strerror}")
    drjit = importlib.metadata.version("drjit")
    key = f"{Path(path).resolve()}|{stat.st_size}|{stat.st_mtime_ns}|drjit {drjit}"
    memo_path = _memo_path()
    memo = _recall(memo_path)
    known = memo.get(key)
    if isinstance(known, list) and len(known) == 2:
        return Verdict(ok=bool(known[0]), detail=str(known[1]))
    verdict = _probe(VARIANTS["llvm"], {LIBRARY_VARIABLE: path})
    if not verdict.lasting:
        return verdict
    try:
        memo_path.parent.mkdir(parents=True, exist_ok=True)
        temporary = memo_path.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps({**memo, key: [verdict.ok, verdict.detail]}))
        temporary.replace(memo_path)
    except OSError:
        pass  # a machine without a cache folder tries again next time
    return verdict


def judge(candidate: Candidate) -> Verdict:
    """Accept a tested version from the project's own wheel; try anything else first."""
    if candidate.tested:
        return Verdict(ok=True, detail=f"LLVM {candidate.version}, a version that simtip tested")
    return try_llvm(candidate.path)


def gpu_present() -> bool:
    """Say whether an NVIDIA driver shows itself, without loading it."""
    if sys.platform == "win32":
        root = os.environ.get("SYSTEMROOT", r"C:\Windows")
        return (Path(root) / "System32" / "nvcuda.dll").exists()
    return Path("/dev/nvidiactl").exists() or Path("/dev/dxg").exists()


@cache
def try_cuda() -> Verdict:
    """Try CUDA and OptiX in a child process."""
    if not gpu_present():
        return Verdict(ok=False, detail="no NVIDIA driver found")
    return _probe(VARIANTS["cuda"], {})


@cache
def _first_llvm() -> tuple[Candidate, Verdict] | None:
    for candidate in candidates():
        verdict = judge(candidate)
        if verdict.ok:
            return candidate, verdict
    return None


def usable_llvm() -> tuple[Candidate, Verdict] | None:
    """Find the LLVM library that this process can use, and why it is trusted.

    If Dr.Jit was imported before simtip could choose, it is the one that Dr.Jit has loaded.
    """
    if "drjit" not in sys.modules:
        return _first_llvm()
    candidate = resident()
    verdict = Verdict(ok=False, detail="") if candidate is None else judge(candidate)
    return (candidate, verdict) if candidate is not None and verdict.ok else None


def settle_llvm() -> None:
    """See to it that Dr.Jit will load an LLVM library that works, or none at all."""
    if "drjit" in sys.modules:
        return
    found = _first_llvm()
    if found is not None:
        os.environ[LIBRARY_VARIABLE] = found[0].path
    elif candidates():
        os.environ[LIBRARY_VARIABLE] = os.devnull
        with _silenced_stderr():  # Dr.Jit complains that this is no library
            importlib.import_module("drjit")


@contextmanager
def _silenced_stderr() -> Iterator[None]:
    """Send what C code writes to stderr nowhere."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def try_backend(backend: Backend) -> Verdict:
    """Render a trial picture on a back end, in a child process."""
    library = {} if backend.libllvm is None else {LIBRARY_VARIABLE: backend.libllvm}
    return _probe(backend.variant, library)


def choose(wanted: str | None = None) -> Backend:
    """Choose a back end.

    Parameters
    ----------
    wanted
        "auto", "cuda", "llvm" or "scalar"; by default the environment variable SIMTIP_BACKEND,
        or else "auto".

    Raises
    ------
    InputError
        No such back end.
    BackendError
        The one that was asked for does not work here.
    """
    asked = wanted or os.environ.get(CHOICE_VARIABLE) or "auto"
    if asked not in ("auto", *VARIANTS):
        raise InputError(
            f"there is no back end {asked!r}",
            field=CHOICE_VARIABLE if wanted is None else "--backend",
            remedy=f"choose from auto, {', '.join(VARIANTS)}",
        )
    if asked in ("auto", "cuda"):
        verdict = try_cuda()
        if verdict.ok:
            return Backend("cuda", f"a GPU {verdict.detail}")
        if asked == "cuda":
            raise BackendError(f"CUDA does not work here: {verdict.detail}; see `simtip doctor`")
    if asked in ("auto", "llvm"):
        found = usable_llvm()
        if found is not None:
            candidate, verdict = found
            return Backend("llvm", f"{candidate.source}: {verdict.detail}", candidate.path)
        if asked == "llvm":
            raise BackendError("no LLVM library that works was found; see `simtip doctor`")
    if asked == "scalar":
        return Backend("scalar", "asked for")
    if "drjit" in sys.modules and _first_llvm() is not None:
        return Backend(
            "scalar",
            "Dr.Jit was imported before simtip, with an LLVM library that does not work; import "
            f"simtip.render.engine first, or set {LIBRARY_VARIABLE}",
        )
    return Backend("scalar", "no GPU and no LLVM library that works")


@contextmanager
def activated(backend: Backend) -> Iterator[None]:
    """Make Mitsuba use the back end within the block, quietly, and restore what was set before."""
    from simtip.render.engine import mi

    loaded = resident()
    if backend.libllvm and loaded is not None and loaded.path not in ("", backend.libllvm):
        raise BackendError(
            f"Dr.Jit has loaded {loaded.path}, not {backend.libllvm}; import simtip.render.engine"
            " first"
        )
    before = mi.variant()
    try:
        mi.set_variant(backend.variant)
    except ImportError as error:
        raise BackendError(
            f"{backend.variant} cannot be started ({' '.join(str(error).split())[:200]}); "
            "see `simtip doctor`"
        ) from error
    level = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield
    finally:
        mi.set_log_level(level)
        if before is not None and before != backend.variant:
            mi.set_variant(before)
