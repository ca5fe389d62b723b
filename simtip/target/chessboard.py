"""The chessboard: points are the inner corners, where four squares meet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array
from simtip.target.target import Lattice, Target, check_counts, check_length, grid, like_a_checker


@dataclass(frozen=True)
class Chessboard(Target):
    """Squares coloured by turns around columns x rows inner corners; the upper left one is black.

    The default is the paper's board: 12 x 9 squares of 6 mm, 88 inner corners. Point 0 is the lower
    right corner of the black square in the upper left. With columns and rows both odd and unequal,
    the board that is white there is not this one turned: it is the one with columns and rows
    exchanged, turned by a quarter, or this one in a mirror.

    Attributes
    ----------
    columns, rows
        Inner corners along x and y.
    square_mm
        Side of a square.

    Raises
    ------
    InputError
        A count outside 2 to 200, or a square without a positive size.
    """

    columns: int = 11
    rows: int = 8
    square_mm: float = 6.0
    family: ClassVar[str] = "chessboard"

    def __post_init__(self) -> None:
        check_counts(self.family, self.columns, self.rows)
        check_length(self.family, "square_mm", self.square_mm)

    def __str__(self) -> str:
        return f"{self.family}:{self.columns}x{self.rows}:{self.square_mm:.12g}"

    @cached_property
    def lattice(self) -> Lattice:
        """(n, 2) column and row of each point, row by row."""
        return grid(self.columns, self.rows)

    @property
    def pitch_mm(self) -> float:
        """Side of a square."""
        return self.square_mm

    @property
    def low(self) -> Array:
        """(2,) mm, the upper left corner of the pattern."""
        return np.array([-self.square_mm, -self.square_mm])

    @property
    def high(self) -> Array:
        """(2,) mm, the lower right corner of the pattern."""
        return np.array([self.columns, self.rows]) * self.square_mm

    def ink(self, st: ArrayLike) -> Array:
        """Say how black the print is at (m, 2) mm: see `Target.ink`."""
        ij = np.floor(np.asarray(st, dtype=np.float64) / self.square_mm) + 1
        i, j = ij[:, 0], ij[:, 1]
        inside = (i >= 0) & (i <= self.columns) & (j >= 0) & (j <= self.rows)
        black: Array = (inside & ((i + j) % 2 == 0)).astype(np.float64)
        return black

    @property
    def half_turn_ambiguous(self) -> bool:
        """Whether it looks the same upside down."""
        return like_a_checker(self.columns + 1, self.rows + 1)[0]

    @property
    def quarter_turn_ambiguous(self) -> bool:
        """Whether it looks the same after a quarter turn."""
        return like_a_checker(self.columns + 1, self.rows + 1)[1]

    @property
    def chiral(self) -> bool:
        """Whether its mirror image is another pattern."""
        return like_a_checker(self.columns + 1, self.rows + 1)[2]
