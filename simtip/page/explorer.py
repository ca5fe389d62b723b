"""What the page's script works on: a sweep's table, and what is shown of it first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.page.columns import Packed, codes, numbers, packed
from simtip.sweep.summary import OK

if TYPE_CHECKING:
    import pandas as pd

NORM = "error_norm_mm"

MEASURED = {
    NORM: ("error, mm", "mm"),
    "refined_norm_mm": ("error refined, mm", "mm"),
    "error_x_mm": ("error in x, mm", "mm"),
    "error_y_mm": ("error in y, mm", "mm"),
    "error_z_mm": ("error in z, mm", "mm"),
    "left_error_along_px": ("left, along, px", "px"),
    "left_error_across_px": ("left, across, px", "px"),
    "right_error_along_px": ("right, along, px", "px"),
    "right_error_across_px": ("right, across, px", "px"),
    "exposure_s": ("exposure, s", "s"),
    "detect_s": ("time of the detector, s", "s"),
}
"""Columns that are numbers: what they are called, and in which unit."""

DRAWN = [name for name in MEASURED if name != "exposure_s"]
LISTED = [name for name in MEASURED if name not in {"exposure_s", "detect_s"}]

MOST_ROWS = 250_000
"""Of more, a page takes so many by lot, and says so."""

ROUND = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True, eq=False)
class Told:
    """A table as the page has it.

    Attributes
    ----------
    data
        For the script.
    settings
        For the script, too.
    left_out
        Rows that there was no room for.
    """

    data: bytes
    settings: dict[str, Any]
    left_out: int


def told(frame: pd.DataFrame, factors: Sequence[str], limit_mm: float | None) -> Told:
    """Give a table to the page's script.

    Parameters
    ----------
    frame
        As `Table.frame` gives it, perhaps with ``bound_mm``.
    factors
        Columns that vary, ``detector`` and ``repeat`` among them if they do.
    limit_mm
        Of the error; None for a round number near its median.
    """
    left_out = max(0, len(frame) - MOST_ROWS)
    if left_out:
        chosen = np.random.default_rng(0).choice(len(frame), MOST_ROWS, replace=False)
        frame = frame.iloc[np.sort(chosen)].reset_index(drop=True)
    columns = [numbers("trial", frame["trial"], whole=True)]
    columns += [codes(name, frame[name]) for name in factors]
    columns.append(codes("status", frame["status"], always=(OK,)))
    measured = [name for name in MEASURED if name in frame and frame[name].notna().any()]
    if NORM not in measured:
        measured.insert(0, NORM)
    columns += [numbers(name, _column(frame, name), MEASURED[name][1]) for name in measured]
    if "bound_mm" in frame:
        columns.append(numbers("bound_mm", frame["bound_mm"], "mm"))
    listed = ["trial", *factors, "status", *(n for n in LISTED if n in measured)]
    if "reason" in frame and frame["reason"].fillna("").ne("").any():
        columns.append(codes("reason", frame["reason"].fillna("")))
        listed.append("reason")
    return Told(
        packed(columns, len(frame)),
        _settings(columns, frame, factors, listed, measured, limit_mm),
        left_out,
    )


def _column(frame: pd.DataFrame, name: str) -> Any:
    import pandas as pd

    return frame[name] if name in frame else pd.Series(np.full(len(frame), math.nan))


def _settings(
    columns: Sequence[Packed],
    frame: pd.DataFrame,
    factors: Sequence[str],
    listed: Sequence[str],
    measured: Sequence[str],
    limit_mm: float | None,
) -> dict[str, Any]:
    errors = _column(frame, NORM).to_numpy(dtype=np.float64, na_value=math.nan)
    known = errors[np.isfinite(errors) & (errors > 0)]
    limit = limit_mm if limit_mm is not None else round_limit(errors)
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.01, 1.0)
    low, high = min(low, limit) / 2, max(high, limit) * 2
    drawn = [name for name in DRAWN if name in measured]
    return {
        "varying": list(factors),
        "listed": list(listed),
        "quantities": [[name, MEASURED[name][0].rpartition(",")[0]] for name in drawn],
        "titles": {name: title for name, (title, _) in MEASURED.items()},
        "start": {
            "x": None,
            "y": None,
            "measure": f"{NORM}:max" if len(known) else "rate",
            "limit": limit,
        },
        "span": [low, high],
        "columns": [column.said["name"] for column in columns],
    }


def round_limit(errors: Any) -> float:
    """Give 1, 2 or 5 times a power of ten, the first at or above the median error, mm."""
    known = np.asarray(errors)[np.isfinite(errors)]
    middle = float(np.median(known)) if len(known) else 0.0
    if not middle > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(middle))
    return float(f"{next(k * power for k in ROUND if k * power >= middle * (1 - 1e-9)):.3g}")
