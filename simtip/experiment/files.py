"""What an experiment leaves in its folder, besides its sweeps."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from simtip.experiment.analysis import Capability
from simtip.experiment.performed import Measured
from simtip.output_folder import write_atomically

RESULT, ROWS = "mca.json", "measurements.csv"

COLUMNS = (
    *("operator", "run", "trial", "part", "reference", "measured", "laser_mm"),
    *(f"{frame}_{axis}_mm" for frame in ("tip", "true", "stage") for axis in "xyz"),
)
"""The first six are those of ``simtip mca --csv``; lengths in mm."""


def write_result(folder: Path, result: dict[str, Any]) -> None:
    """Write what ``--json`` prints.

    Raises
    ------
    InputError
        It cannot be written.
    """
    write_atomically(folder / RESULT, (json.dumps(result, indent=1) + "\n").encode())


def write_rows(folder: Path, capability: Capability) -> None:
    """Write a row a displacement from a run's start, as ``simtip mca --csv`` reads them.

    ``stage_*`` is the measured tip in the stage's frame, empty without a registration.

    Raises
    ------
    InputError
        It cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for part in capability.measured:
        if part.series.is_setup:
            writer.writerows(_rows(part, capability))
    write_atomically(folder / ROWS, text.getvalue().encode())


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
            *(series.name, f"{series.name} {run + 1}", int(run) + 1, nominal),
            *(abs(float(laser[position] - laser[0])), moved, float(laser[position])),
            *(*tip.tolist(), *series.tip_mm[run, position].tolist(), *staged),
        ]
