"""How near a sweep's trials come to the least error that any method can have."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from simtip.bound import KnownBound
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.sweep.frames import plain
from simtip.sweep.remaking import Remaking
from simtip.sweep.varying import DETECT

if TYPE_CHECKING:
    import pandas as pd

MOST_SCENES = 5000
"""That are looked at, of a sweep's different ones."""


def bounds_of(
    frame: pd.DataFrame, factors: Sequence[str], remaking: Remaking, bound: KnownBound
) -> Array:
    """Give the bound of every row's scene, mm; NaN where it is another scene than the bound's.

    Raises
    ------
    InputError
        The bound is of none of the sweep's scenes.
    """
    found = np.full(len(frame), math.nan)
    if bound.norm_mm is None:
        return found
    of_scene = [name for name in factors if not name.startswith(DETECT)]
    groups = _groups(frame, of_scene)
    first: InputError | None = None
    for rows in groups[:MOST_SCENES]:
        row = {name: plain(frame[name].iloc[rows[:1]])[0] for name in frame.columns}
        try:
            bound.require_scene(remaking.again(row).scene)
        except InputError as error:
            first = first or error
        else:
            found[rows] = bound.norm_mm
    if first is not None and np.isnan(found).all():
        raise first
    return found


def _groups(frame: pd.DataFrame, names: Sequence[str]) -> list[list[int]]:
    """Give the rows that agree in all these columns, group by group."""
    found: dict[tuple[object, ...], list[int]] = {}
    columns = [plain(frame[name]) for name in names]
    for row in range(len(frame)):
        found.setdefault(tuple(column[row] for column in columns), []).append(row)
    return list(found.values())
