"""Places in an image that may be points of a target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class Candidates:
    """Places, strongest first, and what neighbours on a target have in common or opposed.

    Attributes
    ----------
    pixels
        (n, 2) u, v.
    phase
        (n,) radians: neighbouring corners of a chessboard differ by about pi. NaN for circles.
    size_px
        (n,) diameter of a circle, alike among neighbours. NaN for corners.
    """

    pixels: Array
    phase: Array
    size_px: Array

    def may_be_neighbours(self, one: int, others: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Say which of the others may stand next to one candidate."""
        turned = np.cos(self.phase[others] - self.phase[one]) < OPPOSED
        ratio = self.size_px[others] / self.size_px[one]
        alike = (ratio < ALIKE) & (ratio > 1 / ALIKE)
        return np.asarray(turned | alike)


OPPOSED = -0.3
"""Largest cosine of the angle between phases that are taken for opposed."""

ALIKE = 1.6
"""Largest ratio of neighbouring circles' diameters."""
