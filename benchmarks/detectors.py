"""How detectors do on every condition: the tables of docs/detectors.md.

python benchmarks/detectors.py --measure              try all built-in detectors, keep the figures
python benchmarks/detectors.py --measure --detector edges:find --only hard
python benchmarks/detectors.py                        print the tables
python benchmarks/detectors.py --write                put them into docs/detectors.md
python benchmarks/detectors.py --quick --poses 1 --exposures 2 --only nominal    a smoke run

Figures of other detectors and conditions that were kept before stay; with `--cache` rendered light
does, too. `--bounds` names a JSON file
with what ``simtip bound --json`` gives by condition, ``{"nominal/cone, pinholes": {...}, ...}``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from detector_conditions import Condition, conditions
from detector_figures import figures
from detector_table import table
from detector_trials import Method, Try, detector_method, tries
from environment import environment

from simtip.detect import catalogue

HERE = Path(__file__).resolve().parent
STORED = HERE / "figures" / "detectors.json"
PAGE = HERE.parent / "docs" / "detectors.md"
BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"

Stored = dict[str, Any]


def built_in() -> list[str]:
    """List the detectors that simtip brings."""
    return [item.name for item in catalogue() if item.source == "built in"]


def all_methods(detectors: list[str]) -> dict[str, Method]:
    """Give what is tried, by name; a method of both images at once would stand here, too."""
    return {name: detector_method(name) for name in detectors}


def measured(
    condition: Condition, methods: dict[str, Method], bounds: Stored, cache: Path | None
) -> Stored:
    """Try the methods on one condition."""
    tried: dict[str, list[Try]] = {name: [] for name in methods}
    for name, one in tries(condition, methods, cache):
        tried[name].append(one)
    bound = bounds.get(f"{condition.group}/{condition.name}")
    return {name: figures(found, bound) for name, found in tried.items()}


def merged(old: Stored, condition: Condition, found: Stored) -> Stored:
    """Give a condition's entry with the new figures in the place of older ones."""
    kept = {(one["group"], one["name"]): one["methods"] for one in old.get("conditions", [])}
    methods = {**kept.get((condition.group, condition.name), {}), **found}
    return {"group": condition.group, "name": condition.name, "methods": methods}


def wanted(condition: Condition, only: list[str] | None) -> bool:
    """Say whether a condition is one of those named by group or name."""
    return not only or condition.group in only or condition.name in only


def measure(given: argparse.Namespace, keep: Callable[[Stored], None]) -> None:
    """Try what is asked for, and keep all figures, older ones as well, after every condition."""
    old: Stored = {} if given.quick or not STORED.exists() else json.loads(STORED.read_text())
    bounds: Stored = json.loads(given.bounds.read_text()) if given.bounds else {}
    methods = all_methods(given.detector or built_in())
    head = {"benchmark": "detectors", "environment": environment(), "quick": given.quick}
    every = conditions(given.poses, given.exposures)
    entries = [merged(old, condition, {}) for condition in every]
    for k, condition in enumerate(every):
        if wanted(condition, given.only):
            print(f"{condition.group}: {condition.name}", file=sys.stderr, flush=True)
            found = measured(condition, methods, bounds, given.cache)
            entries[k] = merged(old, condition, found)
            keep({**head, "conditions": [one for one in entries if one["methods"]]})


def store(figures_now: Stored) -> None:
    """Keep the figures."""
    STORED.write_text(json.dumps(figures_now, indent=1, allow_nan=False) + "\n")


def written(text: str, new: str) -> str:
    """Replace what is between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{new}\n{END}{after}"


def main() -> None:
    """Measure, print or write."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--measure", action="store_true", help="and keep the figures")
    arguments.add_argument("--write", action="store_true", help="into docs/detectors.md")
    arguments.add_argument("--quick", action="store_true", help="keep nothing, print JSON")
    arguments.add_argument("--poses", type=int, default=6, help="of the nominal scenes [6]")
    arguments.add_argument("--exposures", type=int, default=4, help="of every pose [4]")
    arguments.add_argument("--detector", nargs="*", metavar="REF", help="default: all built-in")
    arguments.add_argument("--only", nargs="*", metavar="NAME", help="groups or conditions")
    arguments.add_argument("--bounds", type=Path, metavar="FILE", help="JSON by condition")
    arguments.add_argument("--cache", type=Path, metavar="DIR", help="keeps rendered light")
    given = arguments.parse_args()
    if given.quick:
        kept: list[Stored] = []
        measure(given, kept.append)
        print(json.dumps(kept[-1], indent=1, allow_nan=False))
    elif given.measure:
        measure(given, store)
    elif given.write:
        PAGE.write_text(written(PAGE.read_text(), table(json.loads(STORED.read_text()))))
    else:
        print(table(json.loads(STORED.read_text())))


if __name__ == "__main__":
    main()
