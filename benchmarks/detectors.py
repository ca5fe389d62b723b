"""How detectors do on every condition: the tables of docs/detectors.md.

python benchmarks/detectors.py --measure --cache DIR    try all methods, keep the figures
python benchmarks/detectors.py --measure --cache DIR --resume    go on after an interruption
python benchmarks/detectors.py --measure --method edges:find --only hard
python benchmarks/detectors.py                          print the tables
python benchmarks/detectors.py --write                  put them into docs/detectors.md
python benchmarks/detectors.py --quick --poses 1 --exposures 2 --only nominal    a smoke run

A measurement also works out the bounds that efficiency needs. Every row (a method on a condition)
is kept as soon as it is done, so that an interruption loses one at most. Rows of other methods and
conditions that were kept before stay. With `--cache` rendered light and bounds stay, too; they are
found again by the scene, so empty the folder when the renderer or the bound has changed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from detector_bounds import SAMPLES, Bound, Bounds
from detector_conditions import Condition, conditions
from detector_figures import figures
from detector_methods import SILHOUETTE, Method, NotForThisError, methods_of
from detector_record import Record, Stored, record
from detector_shots import Shots
from detector_table import table
from detector_trials import tries
from environment import environment
from kept_file import keep_json
from marked import replaced

from simtip.detect import catalogue

HERE = Path(__file__).resolve().parent
STORED = HERE / "figures" / "detectors.json"
PAGE = HERE.parent / "docs" / "detectors.md"
BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"


def built_in() -> list[str]:
    """List what simtip brings: its detectors, and the refinement of both images."""
    return [*(item.name for item in catalogue() if item.source == "built in"), SILHOUETTE]


def row(shots: Shots, method: Method, bounds: dict[int, Bound]) -> Stored:
    """Try a method on a condition."""
    try:
        return figures(list(tries(shots, method)), bounds)
    except NotForThisError as error:
        return {"refused": str(error)}


def wanted(condition: Condition, only: list[str] | None) -> bool:
    """Say whether a condition is one of those named by group or name."""
    return not only or condition.group in only or condition.name in only


def measure(given: argparse.Namespace, keep: Callable[[Stored], None]) -> None:
    """Try what is asked for, and keep all figures, older ones as well, after every row."""
    old: Stored = {} if given.quick or not STORED.exists() else json.loads(STORED.read_text())
    methods = methods_of(given.method or built_in())
    every = conditions(given.poses, given.exposures)
    head = {"benchmark": "detectors", "environment": environment(), "quick": given.quick}
    settings = {
        "poses": given.poses,
        "exposures": given.exposures,
        "bound_poses": given.bounds,
        "bound_samples": SAMPLES,
    }
    kept = record(old, head, settings, every, keep, resume=given.resume)
    bounds = Bounds(given.cache)
    for condition in every:
        if wanted(condition, given.only):
            fill(kept, Shots(condition, given.cache), methods, bounds, given.bounds)


def fill(
    kept: Record, shots: Shots, methods: dict[str, Method], bounds: Bounds, bound_poses: int
) -> None:
    """Measure the rows of a condition that are missing."""
    condition = shots.condition
    missing = {name: one for name, one in methods.items() if not kept.has(condition, name)}
    if not missing:
        return
    print(f"{condition.group}: {condition.name}", file=sys.stderr, flush=True)
    least = bounds.of(shots.scenes[:bound_poses])
    for name, method in missing.items():
        print(f"  {name}", file=sys.stderr, flush=True)
        kept.add(condition, name, row(shots, method, least))


def written(text: str, new: str) -> str:
    """Put a table into its place in a page."""
    return replaced(text, new, BEGIN, END)


def options() -> argparse.ArgumentParser:
    """Describe the command line."""
    said = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    said.add_argument("--measure", action="store_true", help="and keep the figures")
    said.add_argument("--resume", action="store_true", help="go on with the kept measurement")
    said.add_argument("--write", action="store_true", help="into docs/detectors.md")
    said.add_argument("--quick", action="store_true", help="keep nothing, print JSON")
    said.add_argument("--poses", type=int, default=6, help="of the nominal scenes [6]")
    said.add_argument("--exposures", type=int, default=4, help="of every pose [4]")
    said.add_argument(
        *("--method", "--detector"),
        nargs="*",
        metavar="REF",
        help=f"detectors, or {SILHOUETTE} [all that simtip brings]",
    )
    said.add_argument("--only", nargs="*", metavar="NAME", help="groups or conditions")
    said.add_argument(
        "--bounds",
        type=int,
        default=2,
        metavar="N",
        help="efficiency over the first N poses of a condition; 0 for none [2]",
    )
    said.add_argument("--cache", type=Path, metavar="DIR", help="keeps rendered light and bounds")
    return said


def main() -> None:
    """Measure, print or write."""
    given = options().parse_args()
    if given.quick:
        kept: list[Stored] = []
        measure(given, kept.append)
        print(json.dumps(kept[-1], indent=1, allow_nan=False))
    elif given.measure:
        measure(given, lambda figures_now: keep_json(STORED, figures_now))
    elif given.write:
        PAGE.write_text(written(PAGE.read_text(), table(json.loads(STORED.read_text()))))
    else:
        print(table(json.loads(STORED.read_text())))


if __name__ == "__main__":
    main()
