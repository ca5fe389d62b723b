"""Find LLVM libraries on this machine, without loading any."""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

WHEEL = "karellen-llvm-core"
TESTED_MAJORS = frozenset({19, 20, 21, 23})
"""LLVM versions of the wheel that rendered rightly with Dr.Jit 1.5; others are tried first."""

_SYSTEM_PATTERNS = {
    "linux": (
        "/usr/lib/llvm-*/lib/libLLVM*.so*",
        "/usr/lib/*/libLLVM*.so*",
        "/usr/lib64/libLLVM*.so*",
        "/usr/lib64/llvm*/lib*/libLLVM*.so*",
        "/usr/lib/libLLVM*.so*",
        "/usr/local/lib/libLLVM*.so*",
    ),
    "darwin": (
        "/opt/homebrew/opt/llvm*/lib/libLLVM.dylib",
        "/usr/local/opt/llvm*/lib/libLLVM.dylib",
        "/opt/local/libexec/llvm-*/lib/libLLVM.dylib",
    ),
    "win32": ("C:/Program Files/LLVM/bin/LLVM-C.dll",),
}


@dataclass(frozen=True)
class Candidate:
    """An LLVM library that was found, not loaded."""

    path: str
    source: str
    version: str | None
    tested: bool = False


def _major(version: str | None) -> int | None:
    match = re.match(r"\d+", version or "")
    return int(match.group()) if match else None


def _version_in_name(path: Path) -> str | None:
    match = re.search(r"(?:LLVM-|llvm-|\.so\.)(\d+(?:\.\d+)*)", str(path))
    return match.group(1) if match else None


def from_wheel() -> Candidate | None:
    """Find the library that pip installed beside simtip."""
    try:
        distribution = importlib.metadata.distribution(WHEEL)
    except importlib.metadata.PackageNotFoundError:
        return None
    for file in distribution.files or ():
        if file.name in ("libLLVM.so", "libLLVM.dylib", "LLVM-C.dll"):
            path = Path(str(distribution.locate_file(file))).resolve()
            if path.exists():
                version = distribution.version
                tested = _major(version) in TESTED_MAJORS
                return Candidate(str(path), f"Python package {WHEEL}", version, tested)
    return None


def _from_environment() -> Candidate | None:
    path = os.environ.get("DRJIT_LIBLLVM_PATH")
    if not path:
        return None
    real = str(Path(path).resolve())  # which is how a loaded library calls itself
    return Candidate(real, "DRJIT_LIBLLVM_PATH", _version_in_name(Path(real)))


def _from_system() -> list[Candidate]:
    found: dict[Path, Candidate] = {}
    for pattern in _SYSTEM_PATTERNS.get(sys.platform, ()):
        anchor = Path(Path(pattern).anchor)
        for path in sorted(anchor.glob(str(Path(pattern).relative_to(anchor)))):
            real = path.resolve()
            if real.is_file() and real not in found:
                found[real] = Candidate(str(real), "system", _version_in_name(real))
    # Newest first: the oldest are the ones that are known to abort.
    return sorted(found.values(), key=lambda c: _major(c.version) or 0, reverse=True)


def candidates() -> list[Candidate]:
    """List libraries in the order of preference: the user's own wish, the wheel, the system's."""
    wheel = from_wheel()
    wish = _from_environment()
    if wish and wheel and Path(wish.path).resolve() == Path(wheel.path):
        wish = None
    ordered = [wish, wheel, *_from_system()]
    unique: dict[str, Candidate] = {}
    for candidate in ordered:
        if candidate is not None:
            unique.setdefault(candidate.path, candidate)
    return list(unique.values())


def resident() -> Candidate | None:
    """Find the library that Dr.Jit has loaded into this process; None if none or not to be told."""
    drjit = sys.modules.get("drjit")
    if drjit is None or not drjit.has_backend(drjit.JitBackend.LLVM):
        return None
    version = ".".join(map(str, drjit.detail.llvm_version()))
    try:
        maps = Path("/proc/self/maps").read_text()
    except OSError:
        # Elsewhere the version has to do.
        return Candidate("", "loaded by Dr.Jit", version, _major(version) in TESTED_MAJORS)
    paths = sorted({line.split(maxsplit=5)[-1] for line in maps.splitlines() if "LLVM" in line})
    wheel = from_wheel()
    for path in paths:
        if wheel is not None and path == wheel.path:
            return wheel
    return Candidate(paths[0], "loaded by Dr.Jit", version) if paths else None
