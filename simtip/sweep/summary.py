"""Statistics of a table's rows that agree in some columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.sweep.frames import kind_of, marks, nearest, require

if TYPE_CHECKING:
    import pandas as pd

OK = "ok"
"""Status of a trial that was measured."""

Values = NDArray[np.float64]

STATISTICS: dict[str, Callable[[Values], float]] = {
    "mean": lambda x: float(np.mean(x)),
    "std": lambda x: float(np.std(x, ddof=1)) if len(x) > 1 else math.nan,
    "rms": lambda x: float(np.sqrt(np.mean(x**2))),
    "median": lambda x: float(np.median(x)),
    "min": lambda x: float(np.min(x)),
    "max": lambda x: float(np.max(x)),
    "p05": lambda x: float(np.percentile(x, 5)),
    "p95": lambda x: float(np.percentile(x, 95)),
    "mean_abs": lambda x: float(np.mean(np.abs(x))),
}
"""What ``column:how`` may ask for, besides ``count``; of one value at least.

``std`` is the sample's, over n - 1; percentiles are interpolated linearly.
"""

COUNT = "count"
RATE = "detection_rate"


def grouped(frame: pd.DataFrame, by: Sequence[str], stats: Sequence[str]) -> pd.DataFrame:
    """Give statistics of the rows that agree in some columns.

    Parameters
    ----------
    frame
        As `Table.frame` gives it.
    by
        Those columns; none makes one group of all rows. A missing value is a value of its own.
    stats
        ``detection_rate`` (share of rows with status ok), ``count`` (of rows), or ``column:how``
        with how one of `STATISTICS` or ``count``, over the rows that have a number there.

    Returns
    -------
    frame
        One row a group, sorted by the columns `by`, missing last: these, ``n`` (rows of the
        group) and the statistics under the names they were asked by. NaN where no row has a
        number.

    Raises
    ------
    InputError
        There is no such column or statistic, or it needs numbers and the column is text.
    """
    import pandas as pd

    by, stats = list(dict.fromkeys(by)), list(dict.fromkeys(stats))
    for name in by:
        require(name, frame, "--by")
    measures = {stat: _measure(stat, frame) for stat in stats}
    firsts, groups = _groups(frame, by)
    told: dict[str, Any] = {"n": pd.array([len(group) for group in groups], dtype="Int64")}
    for stat, (values, figure) in measures.items():
        told[stat] = [figure(values[group]) for group in groups]
        kind = "Int64" if stat.endswith(COUNT) else "float64"
        told[stat] = pd.array(told[stat], dtype=kind) if groups else pd.Series(dtype=kind)
    heads = frame[by].iloc[firsts].reset_index(drop=True)
    return pd.concat([heads, pd.DataFrame(told)], axis=1)


def _groups(frame: pd.DataFrame, by: list[str]) -> tuple[list[int], list[NDArray[np.intp]]]:
    """Give the first row of each group, and all its rows, in order of the groups."""
    rows = np.arange(len(frame))
    if not by:
        return rows[:1].tolist(), [rows]
    keys = [frame[name].reset_index(drop=True) for name in by]
    # By position: several columns of one name, or missing values, would confuse names.
    numbers = frame.reset_index(drop=True).groupby(keys, sort=True, dropna=False).ngroup()
    order = np.argsort(numbers.to_numpy(), kind="stable")
    starts = np.flatnonzero(np.diff(numbers.to_numpy()[order], prepend=-1))
    groups = np.split(order, starts[1:]) if len(starts) else []
    return [int(group[0]) for group in groups], groups


def _measure(stat: str, frame: pd.DataFrame) -> tuple[Values, Callable[[Values], float]]:
    """Give the numbers that a statistic is over, one a row, and what it makes of a group's."""
    if stat == COUNT:
        return np.zeros(len(frame)), len
    if stat == RATE:
        require("status", frame, "--stat")
        return marks(frame["status"] == OK).astype(np.float64), _of_present(STATISTICS["mean"])
    name, _, how = stat.rpartition(":")
    known = [*STATISTICS, COUNT]
    if not name:
        also = [RATE, COUNT, *(f"{column}:mean" for column in frame.columns)]
        raise InputError(
            f"{stat[:200]!r} is no statistic", field="--stat", remedy=nearest(stat, also)
        )
    require(name, frame, "--stat")
    if how not in known:
        raise InputError(
            f"{stat[:200]!r} asks for an unknown statistic {how[:80]!r}",
            field="--stat",
            remedy=nearest(how, known),
        )
    if how == COUNT:
        return marks(frame[name].notna()).astype(np.float64), _total
    return _numbers(frame[name], stat), _of_present(STATISTICS[how])


def _numbers(column: pd.Series[Any], stat: str) -> Values:
    if kind_of(column) == "text":
        raise InputError(
            f"{stat[:200]!r} needs numbers, and the column is text",
            field="--stat",
            remedy="ask for its count",
        )
    return column.to_numpy(dtype=np.float64, na_value=math.nan)


def _total(present: Values) -> int:
    return int(present.sum())


def _of_present(figure: Callable[[Values], float]) -> Callable[[Values], float]:
    """Leave missing numbers out; NaN if there is none."""

    def of_present(values: Values) -> float:
        present = values[~np.isnan(values)]
        if not len(present):
            return math.nan
        with np.errstate(all="ignore"):  # an infinite value makes the figure infinite or NaN
            return figure(present)

    return of_present
