"""A bound on disk: its numbers, and pictures of where the information sits."""

from __future__ import annotations

import json
from pathlib import Path

from simtip.bound import TipBound
from simtip.provenance import environment
from simtip.report.information import plot_information


def write_bound(folder: Path, bound: TipBound) -> None:
    """Write ``bound.json``, and a picture for each view that sees the needle, into a folder."""
    data = {**bound.to_dict(), "environment": environment()}
    (folder / "bound.json").write_text(json.dumps(data, indent=2, allow_nan=False) + "\n")
    for side, view in bound.views.items():
        if view.map is not None:
            (folder / f"{side}_information.png").write_bytes(plot_information(view.map, side))
