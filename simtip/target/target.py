"""What every calibration target tells of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.errors import InputError
from simtip.geometry import Array

Lattice = NDArray[np.intp]

LONGEST_MM = 10_000.0
SIZES = (2, 200)
"""Least and most columns or rows."""


class Target(ABC):
    """A printed pattern with known points, in the board frame (see `simtip.target`).

    Attributes
    ----------
    family
        First word of the target's text, e.g. ``chessboard``.
    """

    family: ClassVar[str]

    @property
    @abstractmethod
    def lattice(self) -> Lattice:
        """(n, 2) whole numbers, column and row of each point: neighbours differ by one step."""

    @property
    @abstractmethod
    def pitch_mm(self) -> float:
        """One step of the lattice, mm."""

    @property
    @abstractmethod
    def low(self) -> Array:
        """(2,) mm, the upper left corner of the box around the printed pattern."""

    @property
    @abstractmethod
    def high(self) -> Array:
        """(2,) mm, the lower right corner of that box."""

    @abstractmethod
    def ink(self, st: ArrayLike) -> Array:
        """Say how black the print is at board points: exact geometry, no raster.

        Parameters
        ----------
        st
            (m, 2) mm. Outside of the pattern there is no ink.

        Returns
        -------
        Array
            (m,), 1 = black ink, 0 = bare paper.
        """

    @abstractmethod
    def __str__(self) -> str:
        """Give the text that `simtip.target.parse_target` reads."""

    @property
    @abstractmethod
    def half_turn_ambiguous(self) -> bool:
        """True if the pattern looks the same upside down: no image tells the first point.

        A finder then numbers from the end that is more to the upper left in the image, which need
        not be the same end in another view: who has several views has to decide between the two.
        """

    @property
    @abstractmethod
    def quarter_turn_ambiguous(self) -> bool:
        """True if the pattern looks the same after a quarter of a turn."""

    @property
    @abstractmethod
    def chiral(self) -> bool:
        """True if a mirror image of the pattern is another pattern, which a finder can tell."""

    @property
    def disc_radius(self) -> float | None:
        """Radius of the disc around each point, in steps of the lattice; None around a corner."""
        return None

    @cached_property
    def points(self) -> Array:
        """(n, 3) mm, z = 0; a point's row is its id."""
        points = np.zeros((len(self.lattice), 3))
        points[:, :2] = self.lattice * self.pitch_mm
        points.setflags(write=False)
        return points


def like_a_checker(across: int, down: int) -> tuple[bool, bool, bool]:
    """Give the symmetry of `across` x `down` cells coloured by parity, the first of them marked.

    Cell (i, j) is marked where i + j is even. So are the squares of a chessboard, and the places of
    a lattice that hold the circles of an asymmetric grid.

    Returns
    -------
    half_turn, quarter_turn, chiral
        Whether a half turn and a quarter turn leave it as it is, and whether no turn undoes a
        mirror.
    """
    half_turn = (across + down) % 2 == 0
    quarter_turn = across == down and across % 2 == 1
    chiral = across % 2 == 0 and down % 2 == 0 and across != down
    return half_turn, quarter_turn, chiral


def check_counts(family: str, columns: int, rows: int) -> None:
    """Refuse a number of columns or rows out of `SIZES`.

    Raises
    ------
    InputError
        Naming the target's family.
    """
    least, most = SIZES
    for name, count in (("columns", columns), ("rows", rows)):
        if not least <= count <= most:
            raise InputError(
                f"a {family} has {least} to {most} {name}, not {count}", field=f"target.{name}"
            )


def check_length(family: str, name: str, length_mm: float) -> None:
    """Refuse a length that is not above 0 and up to `LONGEST_MM`.

    Raises
    ------
    InputError
        Naming the target's family and the length.
    """
    if not 0 < length_mm <= LONGEST_MM:
        raise InputError(
            f"a {family} needs a length above 0 and up to {LONGEST_MM:g} mm, not {length_mm:g}",
            field=f"target.{name}",
        )


def grid(columns: int, rows: int) -> Lattice:
    """Give (columns * rows, 2) column and row, row by row."""
    j, i = np.divmod(np.arange(columns * rows), columns)
    return np.column_stack([i, j]).astype(np.intp)
