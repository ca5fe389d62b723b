"""Errors that the built-in detectors made on the standard suite, measured once.

`errors.npz` holds, of both detectors and every condition, the errors in px (repeats, views, u and
v), whether a tip was measured, and the needle's direction in both views. It is made by
``python measured_errors.py NAME=FOLDER ...`` of folders of sweeps, one a case, as `simtip regress
check -o` leaves them in ``sweeps``.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np

from simtip.regress.conditions import conditions_of, sample_of
from simtip.regress.sample import Sample

FILE = Path(__file__).with_name("errors.npz")


@cache
def _arrays() -> dict[str, np.ndarray]:
    with np.load(FILE, allow_pickle=False) as stored:
        return dict(stored)


def detectors() -> list[str]:
    """Name the detectors that there are errors of."""
    return sorted({name.split("/")[0] for name in _arrays()})


def pool_of(detector: str) -> dict[str, Sample]:
    """Give a detector's samples, by the condition's name."""
    names = [name.split("/")[1] for name in _arrays() if name.startswith(f"{detector}/")]
    return {
        name: Sample(*(_arrays()[f"{detector}/{name}/{part}"] for part in ("found", "px", "axis")))
        for name in dict.fromkeys(names)
    }


def gather(detector: str, folder: Path) -> dict[str, np.ndarray]:
    """Read the errors of a suite's sweeps."""
    from simtip.regress.conditions import full_name
    from simtip.regress.suite import read_suite, sweep_of
    from simtip.sweep.plan import Plan
    from simtip.sweep.table import Table

    found = {}
    for case, place in zip(read_suite("standard").cases, sorted(folder.iterdir()), strict=True):
        frame = Table.open(place).frame()
        frame = frame[frame["detector"] == detector].sort_values("trial")
        rows = [
            {key: None if value != value else value for key, value in row.items()}  # noqa: PLR0124
            for row in frame.astype(object).to_dict("records")
        ]
        levels = len(conditions_of(Plan(sweep_of(case, None), case.sweep.scene)))
        repeats = len(rows) // levels
        spec = sweep_of(case, None).model_copy(update={"repeats": repeats})
        plan = Plan(spec, case.sweep.scene)
        for condition in conditions_of(plan):
            sample = sample_of(plan, condition, dict(enumerate(rows)))
            name = f"{detector}/{full_name(case.name, condition.name)}"
            found[f"{name}/found"] = sample.found
            found[f"{name}/px"] = sample.error_px
            found[f"{name}/axis"] = sample.axis_px
    return found


if __name__ == "__main__":
    arrays: dict[str, np.ndarray] = {}
    for word in sys.argv[1:]:
        name, _, place = word.partition("=")
        arrays |= gather(name, Path(place))
    np.savez_compressed(FILE, **arrays)
