"""The ChArUco board: a chessboard whose white squares carry coded markers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.target.target import Lattice, Target, check_counts, check_length, grid


@dataclass(frozen=True)
class Charuco(Target):
    """columns x rows squares, the upper left black, with ArUco markers in the white ones.

    Markers are numbered from 0 along the rows, as OpenCV does since 4.6 (its earlier pattern, white
    in the upper left if rows are even, is not drawn here). Point 0 is the first inner corner.

    Attributes
    ----------
    columns, rows
        Squares along x and y; the inner corners are one fewer each way.
    square_mm, marker_mm
        Sides of a square and of a marker with its black frame.
    dictionary
        Name of one of OpenCV's sets of markers, e.g. ``DICT_4X4_50``.

    Raises
    ------
    InputError
        A count outside 2 to 200 (or 2 x 2: a single corner), a length that is not positive, a
        marker not smaller than a square, an unknown dictionary or one with too few markers.
    """

    columns: int
    rows: int
    square_mm: float
    marker_mm: float
    dictionary: str = "DICT_4X4_50"
    family: ClassVar[str] = "charuco"

    def __post_init__(self) -> None:
        check_counts(self.family, self.columns, self.rows)
        if self.columns == self.rows == 2:
            raise InputError(
                "a charuco of 2x2 squares has a single corner",
                field="target.columns",
                remedy="give the number of squares, not of inner corners",
            )
        check_length(self.family, "square_mm", self.square_mm)
        check_length(self.family, "marker_mm", self.marker_mm)
        if not self.marker_mm < self.square_mm:
            raise InputError(
                f"a marker of {self.marker_mm:g} mm does not fit into a square of"
                f" {self.square_mm:g} mm",
                field="target.marker_mm",
                remedy="give the square first, then the marker",
            )
        held = len(marker_dictionary(self.dictionary).bytesList)
        if held < self.markers:
            raise InputError(
                f"{self.columns}x{self.rows} squares need {self.markers} markers,"
                f" {self.dictionary} has {held}",
                field="target.dictionary",
                remedy="take a larger dictionary, such as DICT_4X4_1000",
            )

    def __str__(self) -> str:
        lengths = f"{self.square_mm:.12g}:{self.marker_mm:.12g}"
        return f"{self.family}:{self.columns}x{self.rows}:{lengths}:{self.dictionary}"

    @property
    def markers(self) -> int:
        """How many markers the board carries: one in each white square."""
        return self.columns * self.rows // 2

    @cached_property
    def lattice(self) -> Lattice:
        """(n, 2) column and row of each point, row by row."""
        return grid(self.columns - 1, self.rows - 1)

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
        return np.array([self.columns - 1, self.rows - 1]) * self.square_mm

    def ink(self, st: ArrayLike) -> Array:
        """Say how black the print is at (m, 2) mm: see `Target.ink`."""
        squares = np.asarray(st, dtype=np.float64) / self.square_mm + 1
        ij = np.floor(squares)
        i, j = ij[:, 0], ij[:, 1]
        inside = (i >= 0) & (i < self.columns) & (j >= 0) & (j < self.rows)
        white = inside & ((i + j) % 2 == 1)
        black: Array = (inside & ~white).astype(np.float64)
        at = np.flatnonzero(white)
        # Row j has floor(columns / 2) white squares before square i, one more if it begins white.
        before = (j[at] * self.columns + i[at]) // 2
        black[at] = self._marker(before.astype(np.intp), squares[at] - ij[at])
        return black

    def _marker(self, number: NDArray[np.intp], within: Array) -> Array:
        """Read marker cells at places (m, 2), from 0 to 1 across the square."""
        bits = self._bits
        side = bits.shape[1]
        place = (within - 0.5) * (self.square_mm / self.marker_mm) + 0.5
        cell = np.floor(place * side).astype(np.intp)
        inside = ((cell >= 0) & (cell < side)).all(axis=1)
        cell = cell.clip(0, side - 1)
        value: Array = np.where(inside, bits[number, cell[:, 1], cell[:, 0]], 0.0)
        return value

    @cached_property
    def _bits(self) -> Array:
        """(markers, side, side), 1 = black: row, then column, of each marker with its frame."""
        words = marker_dictionary(self.dictionary)
        side = words.markerSize + 2
        drawn = [words.generateImageMarker(k, side, borderBits=1) for k in range(self.markers)]
        return (np.array(drawn) < 128).astype(np.float64)

    @property
    def half_turn_ambiguous(self) -> bool:
        """Whether it looks the same upside down."""
        return False

    @property
    def quarter_turn_ambiguous(self) -> bool:
        """Whether it looks the same after a quarter turn."""
        return False

    @property
    def chiral(self) -> bool:
        """Whether its mirror image is another pattern."""
        return True


def marker_dictionary(name: str) -> cv2.aruco.Dictionary:
    """Look up one of OpenCV's sets of markers; raises InputError if there is none."""
    known = [n for n in dir(cv2.aruco) if n.startswith("DICT_")]
    if name not in known:
        raise InputError(
            f"no dictionary {name!r}",
            field="target.dictionary",
            remedy="take one such as " + ", ".join(n for n in known if n.startswith("DICT_4X4")),
        )
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
