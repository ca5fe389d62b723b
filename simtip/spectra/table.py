"""Tables of the package, read when first asked for."""

from __future__ import annotations

from functools import cache
from importlib import resources

import numpy as np

from simtip.geometry import Array


@cache
def columns(name: str) -> dict[str, Array]:
    """Give the columns of ``tables/<name>.csv`` by their headings; read-only, comments skipped."""
    file = resources.files("simtip.spectra") / "tables" / f"{name}.csv"
    lines = [line for line in file.read_text("utf-8").splitlines() if not line.startswith("#")]
    numbers = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    numbers.flags.writeable = False
    return dict(zip(lines[0].split(","), numbers.T, strict=True))
