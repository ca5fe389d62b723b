"""What a result depends on besides the scene: versions, and the back end that rendered."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Any

from simtip.render import Backend
from simtip.version import __version__

PACKAGES = (
    "mitsuba",
    "drjit",
    "karellen-llvm-core",
    "numpy",
    "scipy",
    "opencv-python-headless",
    "trimesh",
)


def environment() -> dict[str, Any]:
    """Name the versions that a result depends on."""
    versions: dict[str, str | None] = {}
    for name in PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = None
    return {
        "simtip": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": versions,
    }


def backend_facts(backend: Backend) -> dict[str, Any]:
    """Say what rendered and why it was chosen."""
    return {
        "name": backend.name,
        "variant": backend.variant,
        "reason": backend.reason,
        "libllvm": backend.libllvm,
    }
