"""A sweep's map and distributions as figures that stay as they are, for files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.page.columns import levels_of
from simtip.page.explorer import NORM, round_limit
from simtip.page.parts import Drawing
from simtip.sweep.frames import kind_of, plain
from simtip.sweep.summary import OK

if TYPE_CHECKING:
    import pandas as pd

MOST_LEVELS = 40
MOST_GROUPS = 14


def still_figures(
    frame: pd.DataFrame, varying: Sequence[str], limit_mm: float | None
) -> list[Drawing]:
    """Draw what the page's script shows first, one map a detector, and the distributions."""
    if NORM not in frame or not frame[NORM].notna().any():
        return []
    from simtip.report.distributions import distributions_figure

    made = []
    detectors = list(dict.fromkeys(plain(frame["detector"]))) if "detector" in frame else [None]
    errors = frame[NORM].to_numpy(dtype=np.float64, na_value=math.nan)
    limit = round_limit(errors) if limit_mm is None else limit_mm
    factors = _two(frame, [name for name in varying if name not in {"detector", "repeat"}])
    groups = []
    for number, detector in enumerate(detectors[:MOST_GROUPS]):
        own = frame if detector is None else frame[frame["detector"] == detector]
        name = "all trials" if detector is None else str(detector)
        if factors is not None:
            made.append(_map(own, factors, limit, name, number))
        values = own[NORM].to_numpy(dtype=np.float64, na_value=math.nan)
        if np.isfinite(values).any():
            groups.append((name, values[np.isfinite(values)]))
    caption = "Distribution of the error by detector."
    return [*made, Drawing("distributions", caption, distributions_figure(groups))]


def _two(frame: pd.DataFrame, names: Sequence[str]) -> tuple[str, str] | None:
    """Choose the two factors with most levels, numbers before texts."""
    import pandas as pd

    fitting = [name for name in names if frame[name].nunique(dropna=False) <= MOST_LEVELS]
    ranked = sorted(fitting, key=lambda name: _rank(pd.Series(frame[name])))
    return (ranked[0], ranked[1]) if len(ranked) > 1 else None


def _rank(column: pd.Series[Any]) -> tuple[bool, int]:
    return kind_of(column) == "text", -column.nunique(dropna=False)


def _map(
    frame: pd.DataFrame, factors: tuple[str, str], limit: float, name: str, number: int
) -> Drawing:
    from simtip.report.envelope import Envelope, envelope_figure

    (x, across), (y, up) = (levels_of(frame[factor]) for factor in factors)
    errors = frame[NORM].to_numpy(dtype=np.float64, na_value=math.nan)
    ok = (frame["status"] == OK).fillna(value=False).to_numpy(dtype=bool)
    largest, rate = (np.full((len(up), len(across)), math.nan) for _ in range(2))
    for row, column in np.ndindex(largest.shape):
        cell = (y == row) & (x == column)
        if cell.any():
            rate[row, column] = ok[cell].mean()
            known = errors[cell][np.isfinite(errors[cell])]
            largest[row, column] = known.max() if len(known) else math.nan
    found = Envelope(f"{name}: largest error", factors, across, up, largest, rate, limit)
    caption = f"Largest error of {name} over {factors[0]} and {factors[1]}."
    return Drawing(f"envelope_{number + 1}", caption, envelope_figure(found))
