"""Readings in the order of a motion, as displacements and as steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.capability.interval import Array, paired

Kind: TypeAlias = Literal["displacement", "position", "step"]
"""What a reading is: the displacement from the run's start, where both methods say 0; a position
along the motion, from any zero; or the displacement from the reading before."""


@dataclass(frozen=True)
class Motion:
    """Measured and reference values of runs put one after the other.

    Attributes
    ----------
    rows
        (n,) which reading each of `measured`, `reference` is of.
    measured, reference
        (n,) the displacements that errors are of: as read, but from the run's first position.
    steps
        Measured and reference, (m,) each: distances from one reading to the next, Eq. 1 and 2.
    cumulative
        Measured and reference, (n,) each: displacements from the run's start.
    """

    rows: NDArray[np.intp]
    measured: Array
    reference: Array
    steps: tuple[Array, Array]
    cumulative: tuple[Array, Array]


def motion(
    measured: ArrayLike, reference: ArrayLike, runs: Sequence[object], kind: Kind = "displacement"
) -> Motion:
    """Put readings in order.

    Parameters
    ----------
    measured, reference
        (n,) readings, those of one run in the order of its motion.
    runs
        (n,) which run a reading is of.
    kind
        What a reading is.

    Raises
    ------
    ValueError
        Lengths differ or a number is not finite.
    """
    both = np.stack(paired(measured, reference, 1))
    if len(runs) != both.shape[1]:
        raise ValueError(f"{len(runs)} runs do not go with {both.shape[1]} readings")
    order: dict[object, list[int]] = {}
    for row, run in enumerate(runs):
        order.setdefault(run, []).append(row)
    pieces = [_run(both[:, rows], np.array(rows), kind) for rows in order.values()]
    rows = np.concatenate([piece[0] for piece in pieces])
    read, steps, whole = (np.concatenate([piece[k] for piece in pieces], axis=1) for k in (1, 2, 3))
    by_row = np.argsort(rows)
    return Motion(
        rows=rows[by_row],
        measured=read[0, by_row],
        reference=read[1, by_row],
        steps=(steps[0], steps[1]),
        cumulative=(whole[0, by_row], whole[1, by_row]),
    )


def _run(
    both: Array, rows: NDArray[np.intp], kind: Kind
) -> tuple[NDArray[np.intp], Array, Array, Array]:
    """Give rows, displacements, steps and displacements from the start, (2, .) each, of one run."""
    if kind == "step":
        return rows, both, both, np.cumsum(both, axis=1)
    if kind == "position":
        whole = np.abs(both[:, 1:] - both[:, :1])
        return rows[1:], whole, np.abs(np.diff(both, axis=1)), whole
    # The start is no row unless it says so.
    start = np.zeros((2, 0 if both[1, 0] == 0 else 1))
    return rows, both, np.abs(np.diff(np.hstack([start, both]), axis=1)), both
