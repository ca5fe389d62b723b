"""What an experiment leaves in its folder, besides its sweeps."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from simtip.experiment.analysis import positions_along
from simtip.experiment.performed import Measured
from simtip.experiment.result import Capability
from simtip.output_folder import write_atomically

RESULT, ROWS = "mca.json", "measurements.csv"
STEPS, GAUGE = "steps.csv", "gauge.csv"

COLUMNS = (
    *("run", "trial", "part", "reference", "measured", "laser_mm"),
    *(f"{frame}_{axis}_mm" for frame in ("tip", "true", "stage") for axis in "xyz"),
)
"""The first five are those of ``simtip mca --csv``; lengths in mm."""


def write_result(folder: Path, result: dict[str, Any]) -> None:
    """Write what ``--json`` prints.

    Raises
    ------
    InputError
        It cannot be written.
    """
    write_atomically(folder / RESULT, (json.dumps(result, indent=1) + "\n").encode())


def write_rows(folder: Path, capability: Capability) -> None:
    """Write what ``simtip mca --csv`` reads, so that it gives the same figures.

    ``measurements.csv`` has a row a displacement of the first set-up from a run's start, with the
    tip in the world's and in the stage's frame (empty without a registration); ``steps.csv`` the
    steps that count for accuracy; ``gauge.csv``, if there are several set-ups, positions along the
    first axis by place, set-up and run.

    Raises
    ------
    InputError
        It cannot be written.
    """
    _write(folder / ROWS, COLUMNS, _rows(capability.measured[0], capability))
    steps = capability.steps
    rows = zip(steps.run, steps.position, steps.reference, steps.measured, strict=True)
    _write(
        folder / STEPS,
        ("run", "part", "reference", "measured"),
        ([run + 1, part, *pair] for run, part, *pair in rows),
    )
    if capability.grr is not None:
        _write(folder / GAUGE, ("part", "operator", "trial", "measured"), _gauge_rows(capability))


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    write_atomically(path, text.getvalue().encode())


def _gauge_rows(capability: Capability) -> Iterator[list[object]]:
    parts = [part for part in capability.measured if part.series.is_setup]
    runs = capability.spec.schedule.setup_runs
    along = [one[:runs] for one in positions_along(parts)]
    everywhere = np.atleast_1d(np.isfinite(np.concatenate(along)).all(axis=0))
    for part, places in zip(parts, along, strict=True):
        for run, place in np.ndindex(places.shape):
            if everywhere[place]:
                yield [place + 1, part.series.name, run + 1, float(places[run, place])]


def _rows(part: Measured, capability: Capability) -> Iterator[list[object]]:
    series, frame = part.series, capability.frame
    for run, position in zip(*np.nonzero(part.ok), strict=True):
        if position == 0 or not part.ok[run, 0]:
            continue
        tip, laser = part.tip_mm[run, position], series.laser_mm[run]
        moved = float(np.linalg.norm(tip - part.tip_mm[run, 0]))
        asked = series.commanded_mm[run]
        nominal = round(float(asked[position, 0] - asked[0, 0]), 6)
        staged = ["", "", ""] if frame is None else frame.registration.apply(tip).tolist()
        yield [
            *(int(run) + 1, int(run) + 1, nominal),
            *(abs(float(laser[position] - laser[0])), moved, float(laser[position])),
            *(*tip.tolist(), *series.tip_mm[run, position].tolist(), *staged),
        ]
