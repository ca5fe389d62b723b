"""The balanced layout that a gauge study needs: every part by every operator, equally often."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from simtip.capability.interval import Array, spread


def balanced(values: ArrayLike) -> Array:
    """Take a study (p, o, r) of parts, operators and trials.

    Raises
    ------
    ValueError
        There are fewer than 2 of something, a number is not finite, or no two values differ.
    """
    y = np.asarray(values, dtype=np.float64)
    if y.ndim != 3 or not np.isfinite(y).all():
        raise ValueError("a gauge study is finite numbers by part, operator and trial")
    for name, count in zip(("part", "operator", "trial"), y.shape, strict=True):
        if count < 2:
            raise ValueError(f"a gauge study needs at least 2 {name}s, not {count}")
    if spread(y.ravel()) == 0:
        raise ValueError("all measured values are equal: there is no variation to split")
    return y


def crossed(
    values: ArrayLike, parts: Sequence[object], operators: Sequence[object]
) -> tuple[Array, list[object], list[object]]:
    """Lay measurements out by part, operator and trial.

    Parameters
    ----------
    values, parts, operators
        (n,) each: the measurement, of which part, by which operator; trials in their order.

    Returns
    -------
    study
        (p, o, r).
    part_names, operator_names
        In the order of the study, which is that of their first row.

    Raises
    ------
    ValueError
        Lengths differ, or a part was measured by an operator less often than others: it is named.
    """
    array = np.asarray(values, dtype=np.float64)
    if not len(array) == len(parts) == len(operators):
        raise ValueError(f"{len(array)} values, {len(parts)} parts, {len(operators)} operators")
    names, people = list(dict.fromkeys(parts)), list(dict.fromkeys(operators))
    cells: dict[tuple[object, object], list[float]] = {(n, w): [] for n in names for w in people}
    for value, name, who in zip(array, parts, operators, strict=True):
        cells[name, who].append(float(value))
    most = max(map(len, cells.values()))
    for (name, who), cell in cells.items():
        if len(cell) < most:
            raise ValueError(
                f"part {name!s} was measured {len(cell)} times by operator {who!s}, and others "
                f"{most} times"
            )
    study = np.array([[cells[name, who] for who in people] for name in names])
    return study, names, people
