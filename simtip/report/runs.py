"""Which colour and marker a run has in every plot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.report.style import BLUE, GRAY, GREEN, ORANGE, literal

COLORS = (BLUE, ORANGE, GREEN, "#E69F00", "#56B4E9", "#CC79A7")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
"""So that runs are told apart without colours too."""

LONGEST_NAME = 20
SHORT_NAME = 3
"""Letters; so short a name says nothing without the word run."""


@dataclass(frozen=True)
class Run:
    """The rows (m,) of one run, its name in a legend, and how its points look."""

    rows: NDArray[np.intp]
    name: str
    look: dict[str, Any]


def runs_of(labels: Sequence[object] | None, count: int) -> Iterator[Run]:
    """Give the runs of so many points, in the order in which they come.

    More than there are markers cannot be told apart: they look alike, and only the first has a
    name, that of all.

    Parameters
    ----------
    labels
        (n,) which run a point is of; None if that does not matter.

    Raises
    ------
    ValueError
        There are not as many labels as points.
    """
    if labels is not None and len(labels) != count:
        raise ValueError(f"{len(labels)} runs do not go with {count} values")
    groups: dict[object, list[int]] = {}
    for row, label in enumerate(labels if labels is not None else [None] * count):
        groups.setdefault(label, []).append(row)
    size = 5.5 if count <= 100 else 4.5
    alike = len(groups) == 1 or len(groups) > len(MARKERS)
    for k, (label, rows) in enumerate(groups.items()):
        color, marker = (BLUE, "o") if len(groups) == 1 else (GRAY, "o")
        name = "" if k or len(groups) == 1 else f"{len(groups)} runs"
        if not alike:
            color, marker, name = COLORS[k % len(COLORS)], MARKERS[k], _name(label)
        look = {"color": color, "marker": marker, "ms": size, "mec": "white", "mew": 0.4}
        if not alike:  # hollow: where runs agree, none hides another
            look |= {"mfc": "none", "mec": color, "mew": 1.1}
        yield Run(np.array(rows), name, look)


def _name(label: object) -> str:
    """Name a run; keys of tables are tuples of texts."""
    text = " ".join(map(str, label)) if isinstance(label, tuple) else str(label)
    text = text if text.strip() else "-"
    short = text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 2]}.."
    return literal(short if len(short) > SHORT_NAME else f"run {short}")
