"""How near a pose's scatter is to its bound: the last table of docs/detectors.md.

python benchmarks/scatter.py --measure --cache DIR    expose the same poses again and again
python benchmarks/scatter.py                          print the table
python benchmarks/scatter.py --write                  put it into docs/detectors.md
python benchmarks/scatter.py --quick                  a smoke run without bounds

All exposures of a pose are by one pair of cameras, so that fresh noise alone tells them apart, and
each view has its own bound. What `subpixel` claims for one picture, its own Fisher information with
the needle's brightness, shape and blur unknown, is set against the same bound.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from detector_bounds import Bound, Bounds
from detector_conditions import conditions
from detector_methods import detector_method
from detector_shots import Shots
from detector_trials import SIDES, Look, tries
from detectors import PAGE
from environment import environment
from kept_file import keep_json
from marked import replaced

STORED = Path(__file__).resolve().parent / "figures" / "scatter.json"
BEGIN, END = "<!-- scatter: begin -->", "<!-- scatter: end -->"
POSES = 20
"""Of the nominal scenes, as docs/detectors.md has them; the first few are looked at."""
WAYS = ("along", "across")
HEAD = (
    *("condition", "pose", "view", "scatter along, px", "across"),
    *("scatter / bound along", "across", "claimed / bound along", "across"),
)


def view_row(looks: list[Look], bound: dict[str, Any] | None) -> dict[str, Any]:
    """Give scatter and claim of one view's exposures, along and across, and its bound, px."""
    told = [one for one in looks if one.along_px is not None and one.claimed_px2 is not None]
    errors = np.array([(one.along_px, one.across_px) for one in told], np.float64)
    claims = np.sqrt(np.mean([one.claimed_px2 for one in told], axis=0))
    scatter = errors.std(axis=0, ddof=1)
    return {
        "exposures": len(looks),
        "found": len(told),
        "scatter_px": dict(zip(WAYS, scatter.tolist(), strict=True)),
        "claimed_px": dict(zip(WAYS, claims.tolist(), strict=True)),
        "bound_px": bound,
    }


def measured(shots: Shots, bounds: dict[int, Bound]) -> list[dict[str, Any]]:
    """Try `subpixel` on every exposure of a condition: a row for each pose and view."""
    looks: dict[tuple[int, str], list[Look]] = {}
    for one in tries(shots, detector_method("subpixel")):
        for look in one.looks:
            looks.setdefault((look.pose, look.side), []).append(look)
    return [
        {"condition": shots.condition.name, "pose": pose, "view": side}
        | view_row(looks[pose, side], bounds[pose]["bound_px"][side] if bounds else None)
        for pose, side in sorted(looks, key=lambda key: (key[0], SIDES.index(key[1])))
    ]


def measure(given: argparse.Namespace) -> dict[str, Any]:
    """Measure the nominal conditions' first poses."""
    bounds, rows = Bounds(given.cache), []
    for condition in conditions(POSES, given.exposures):
        if condition.group != "nominal":
            continue
        shots = Shots(condition, given.cache, one_camera=True)
        shots.scenes = shots.scenes[: given.poses]
        print(condition.name, file=sys.stderr, flush=True)
        rows += measured(shots, {} if given.quick else bounds.of(shots.scenes))
    head = {"benchmark": "scatter", "environment": environment(), "quick": given.quick}
    return {**head, "rows": rows}


def table(stored: dict[str, Any]) -> str:
    """Make the Markdown."""
    lines = [f"| {' | '.join(HEAD)} |", "| --- | ---: | --- |" + " ---: |" * (len(HEAD) - 3)]
    for row in stored["rows"]:
        scatter, claimed, bound = (row[f"{key}_px"] for key in ("scatter", "claimed", "bound"))
        numbers = [f"{scatter[way]:.4f}" for way in WAYS]
        for given in (scatter, claimed):
            numbers += [_over(given[way], bound and bound[way]) for way in WAYS]
        lines.append(
            f"| {row['condition']} | {row['pose']} | {row['view']} | {' | '.join(numbers)} |"
        )
    exposures = {row["exposures"] for row in stored["rows"]}
    said = " or ".join(str(number) for number in sorted(exposures))
    return f"Of {said} exposures each.\n\n" + "\n".join(lines)


def _over(deviation: float, bound: float | None) -> str:
    """Give a ratio as text; a view may not determine a parameter, and has no bound then."""
    return f"{deviation / bound:.1f}" if bound else ""


def written(text: str, new: str) -> str:
    """Put a table into its place in a page."""
    return replaced(text, new, BEGIN, END)


def options() -> argparse.ArgumentParser:
    """Describe the command line."""
    said = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    said.add_argument("--measure", action="store_true", help="and keep the figures")
    said.add_argument("--write", action="store_true", help="into docs/detectors.md")
    said.add_argument("--quick", action="store_true", help="keep nothing, print JSON")
    said.add_argument("--poses", type=int, default=2, help="of each condition [2]")
    said.add_argument("--exposures", type=int, default=24, help="of every pose [24]")
    said.add_argument("--cache", type=Path, metavar="DIR", help="keeps rendered light and bounds")
    return said


def main() -> None:
    """Measure, print or write."""
    given = options().parse_args()
    if given.quick:
        print(json.dumps(measure(given), indent=1, allow_nan=False))
    elif given.measure:
        keep_json(STORED, measure(given))
    elif given.write:
        PAGE.write_text(written(PAGE.read_text(), table(json.loads(STORED.read_text()))))
    else:
        print(table(json.loads(STORED.read_text())))


if __name__ == "__main__":
    main()
