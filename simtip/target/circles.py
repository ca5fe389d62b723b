"""Grids of circles: points are the centres."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.target.target import Lattice, Target, check_counts, check_length, grid, like_a_checker


@dataclass(frozen=True)
class _Circles(Target):
    """Black discs on a lattice."""

    columns: int
    rows: int
    spacing_mm: float
    diameter_mm: float

    def __post_init__(self) -> None:
        check_counts(f"{self.family} grid", self.columns, self.rows)
        check_length(f"{self.family} grid", "spacing_mm", self.spacing_mm)
        check_length(f"{self.family} grid", "diameter_mm", self.diameter_mm)
        if not self.diameter_mm < self.nearest_mm:
            raise InputError(
                f"circles of {self.diameter_mm:g} mm touch at a distance of {self.nearest_mm:.4g}"
                " mm",
                field="target.diameter_mm",
                remedy="give the diameter below the distance of neighbouring centres",
            )

    def __str__(self) -> str:
        lengths = f"{self.spacing_mm:.12g}:{self.diameter_mm:.12g}"
        return f"{self.family}:{self.columns}x{self.rows}:{lengths}"

    @property
    def disc_radius(self) -> float | None:
        """Radius of a circle, in steps of the lattice."""
        return self.diameter_mm / 2 / self.spacing_mm

    @property
    @abstractmethod
    def nearest_mm(self) -> float:
        """Distance of the nearest centres, mm."""

    @property
    def pitch_mm(self) -> float:
        """The spacing."""
        return self.spacing_mm

    @property
    def low(self) -> Array:
        """(2,) mm, the upper left corner of the pattern."""
        return np.full(2, -self.diameter_mm / 2)

    @property
    def high(self) -> Array:
        """(2,) mm, the lower right corner of the pattern."""
        extent: Array = self.lattice.max(axis=0) * self.spacing_mm + self.diameter_mm / 2
        return extent


@dataclass(frozen=True)
class CircleGrid(_Circles):
    """columns x rows circles on a square lattice.

    It always looks the same upside down, see `Target.half_turn_ambiguous`.

    Attributes
    ----------
    columns, rows
        Circles along x and y.
    spacing_mm
        Distance of neighbouring centres.
    diameter_mm
        Of a circle.

    Raises
    ------
    InputError
        A count outside 2 to 200, a length that is not positive, or circles that touch.
    """

    family: ClassVar[str] = "circles"

    @cached_property
    def lattice(self) -> Lattice:
        """(n, 2) column and row of each point, row by row."""
        return grid(self.columns, self.rows)

    @property
    def nearest_mm(self) -> float:
        """Distance of the nearest centres, mm."""
        return self.spacing_mm

    def ink(self, st: ArrayLike) -> Array:
        """Say how black the print is at (m, 2) mm: see `Target.ink`."""
        xy = np.asarray(st, dtype=np.float64)
        most = (self.columns - 1, self.rows - 1)
        nearest = np.rint(xy / self.spacing_mm).clip(0, most) * self.spacing_mm
        return _within(xy - nearest, self.diameter_mm)

    @property
    def half_turn_ambiguous(self) -> bool:
        """Whether it looks the same upside down."""
        return True

    @property
    def quarter_turn_ambiguous(self) -> bool:
        """Whether it looks the same after a quarter turn."""
        return self.columns == self.rows

    @property
    def chiral(self) -> bool:
        """Whether its mirror image is another pattern."""
        return False


@dataclass(frozen=True)
class AsymmetricCircles(_Circles):
    """rows of `columns` circles each, every second row half a step to the right.

    As in OpenCV, centres in a row are 2 spacings apart, rows are 1 spacing apart, and the odd rows
    (counted from 0) begin at x = 1 spacing. A grid with an even number of rows looks the same
    upside down and is chiral unless its box is a square; with an odd number it is neither.

    Attributes
    ----------
    columns
        Circles in a row.
    rows
        Rows.
    spacing_mm
        Distance of rows, half the distance of centres in a row.
    diameter_mm
        Of a circle.

    Raises
    ------
    InputError
        A count outside 2 to 200, a length that is not positive, or circles that touch.
    """

    family: ClassVar[str] = "asymmetric"

    @cached_property
    def lattice(self) -> Lattice:
        """(n, 2) column and row of each point, row by row."""
        rows = grid(self.columns, self.rows)
        return np.column_stack([2 * rows[:, 0] + rows[:, 1] % 2, rows[:, 1]])

    @property
    def nearest_mm(self) -> float:
        """Distance of the nearest centres, mm."""
        return self.spacing_mm * math.sqrt(2)

    def ink(self, st: ArrayLike) -> Array:
        """Say how black the print is at (m, 2) mm: see `Target.ink`."""
        xy = np.asarray(st, dtype=np.float64)
        black = np.zeros(len(xy))
        for odd in (0, 1):
            # The even and the odd rows are two lattices of 2 x 2 spacings.
            first = np.array([odd, odd]) * self.spacing_mm
            step = 2 * self.spacing_mm
            most = (self.columns - 1, (self.rows - 1 - odd) // 2)
            nearest = np.rint((xy - first) / step).clip(0, most) * step + first
            black += _within(xy - nearest, self.diameter_mm)
        return black

    @property
    def half_turn_ambiguous(self) -> bool:
        """Whether it looks the same upside down."""
        return like_a_checker(2 * self.columns, self.rows)[0]

    @property
    def quarter_turn_ambiguous(self) -> bool:
        """Whether it looks the same after a quarter turn."""
        return like_a_checker(2 * self.columns, self.rows)[1]

    @property
    def chiral(self) -> bool:
        """Whether its mirror image is another pattern."""
        return like_a_checker(2 * self.columns, self.rows)[2]


def _within(offset: Array, diameter_mm: float) -> Array:
    inside: Array = (offset[:, 0] ** 2 + offset[:, 1] ** 2 <= diameter_mm**2 / 4).astype(np.float64)
    return inside
