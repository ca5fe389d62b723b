"""Where a tip's fit begins: values that edges or another fit suggest, held against the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.detect.subpixel.comparison import Comparison, compare
from simtip.detect.subpixel.outline import Family
from simtip.detect.subpixel.scenery import POSE, Scenery
from simtip.geometry import Array

USUALLY_AHEAD_PX, ELSE_AHEAD_PX = 2.5, (0.0, 5.0)
"""How far beyond the last row that shows the needle its end is, and else may be: rows fall short of
it."""

TWINS = ("bevel", "bevel_away")
"""Each other's mirror image in depth: where one fits badly, the other may begin."""

ROUNDED = 0.1
"""Of a cone's end, half widths, to see whether a round one fits better."""


@dataclass(frozen=True, eq=False)
class Start:
    """Values of an outline, held against the picture."""

    values: Array
    found: Comparison

    @classmethod
    def at(cls, scenery: Scenery, family: Family, values: Array) -> Start:
        """Hold an outline against the picture."""
        return cls(values, compare(scenery, family, values))


def best_start(scenery: Scenery, family: Family, candidates: list[Array]) -> Start:
    """Give the best of some values, one at least."""
    starts = [Start.at(scenery, family, values) for values in candidates]
    return min(starts, key=lambda one: one.found.cost)


def usual_values(scenery: Scenery, family: Family, v_end: float, begin: Array) -> list[Array]:
    """Give values to begin with: the family's usual shapes.

    Parameters
    ----------
    scenery
        The pixels and the shaft.
    family
        The outline.
    v_end
        The last row that shows the needle.
    begin
        What the edges suggest, see `simtip.detect.subpixel.start`.
    """
    pose = [v_end + USUALLY_AHEAD_PX, 0.0, scenery.half_px, scenery.begun_px2, 0.0]
    return [np.array([*pose, *shape]) for shape in family.starts(begin)]


def elsewhere(scenery: Scenery, family: Family, start: Start, v_end: float) -> Start:
    """Give a start with its end at another row, if that fits better."""
    rows = (v_end + ahead for ahead in ELSE_AHEAD_PX)
    others = (Start.at(scenery, family, np.array([row, *start.values[1:]])) for row in rows)
    return min((start, *others), key=lambda one: one.found.cost)


def like(family: Family, name: str, values: Array) -> list[Array]:
    """Give the values, none or one, at which a family looks as one called so does at `values`."""
    pose, shape = values[:POSE], values[POSE:]
    if name == family.name or {name, family.name} == set(TWINS):
        return [values]
    if name == "cone" and family.name == "wedge":
        return [np.array([*pose, 0.0, shape[0], shape[0]])]
    if name == "wedge" and family.name == "cone":
        return [np.array([*pose, (shape[1] + shape[2]) / 2])]
    if name == "round" and family.name == "cone":
        length, radius = shape
        rounded = radius * (np.hypot(1, length) - 1)  # how far the sharp apex lies in front
        return [np.array([pose[0] + values[2] * rounded, *pose[1:], length])]
    if name == "cone" and family.name == "round":
        return [np.array([*pose, shape[0], ROUNDED])]
    return []
