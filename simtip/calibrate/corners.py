"""The points seen by one camera in all views, in one table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.target.sighting import Sighting


@dataclass(frozen=True, eq=False)
class View:
    """One position of the target.

    Attributes
    ----------
    name
        What the view is called in messages and results.
    left, right
        What each camera saw of the target, or None where it was not found.
    """

    name: str
    left: Sighting | None
    right: Sighting | None


@dataclass(frozen=True, eq=False)
class Corners:
    """Points of the target and where one camera saw them.

    Attributes
    ----------
    view
        (n,) index of the view, ascending.
    ids
        (n,) which of the target's points, ascending within a view.
    points_mm
        (n, 3) in the target's frame.
    pixels
        (n, 2) u, v, px of the image as it is.
    """

    view: NDArray[np.intp]
    ids: NDArray[np.intp]
    points_mm: Array
    pixels: Array

    def __len__(self) -> int:
        return len(self.view)

    def kept(self, keep: NDArray[np.bool_]) -> Corners:
        """Give those for which `keep` (n,) is true."""
        return Corners(self.view[keep], self.ids[keep], self.points_mm[keep], self.pixels[keep])

    def slices(self, views: int) -> list[slice]:
        """Give the rows of each of `views` views."""
        ends = np.searchsorted(self.view, np.arange(views + 1))
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def corners_of(sightings: Sequence[Sighting | None], points_mm: Array) -> Corners:
    """Put the sightings of one camera, one or None per view, into a table.

    Parameters
    ----------
    sightings
        One per view.
    points_mm
        (m, 3) the target's points.
    """
    seen = [(i, s) for i, s in enumerate(sightings) if s is not None]
    view = [np.full(len(s.ids), i, dtype=np.intp) for i, s in seen]
    ids = np.concatenate([np.zeros(0, dtype=np.intp), *(s.ids for _, s in seen)])
    return Corners(
        view=np.concatenate([np.zeros(0, dtype=np.intp), *view]),
        ids=ids,
        points_mm=points_mm[ids],
        pixels=np.concatenate([np.zeros((0, 2)), *(s.pixels for _, s in seen)]),
    )
