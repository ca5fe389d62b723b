"""One value in a rig file, and where it stands: read with its error ready."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.yaml_file import Document, FieldPath, Yaml, shown

MAX_MAGNITUDE = 1e8
"""Largest focal length, principal point (px), coefficient and baseline (mm) taken seriously."""
MAX_SIDE = 65535
"""Largest image side, px."""


@dataclass(frozen=True)
class Field:
    """A value of unknown kind in a file.

    Attributes
    ----------
    document
        The file.
    path
        Where in it the value stands.
    value
        The value.
    remedy
        What to do when it is malformed; each format has its own.
    """

    document: Document
    path: FieldPath
    value: Yaml
    remedy: str

    @classmethod
    def root(cls, document: Document, remedy: str) -> Field:
        """Give the whole of a document."""
        return cls(document, (), document.value, remedy)

    def error(self, problem: str, remedy: str | None = None) -> InputError:
        """Make the error that names the file, the line and the field."""
        return self.document.error(problem, self.path, remedy=remedy or self.remedy)

    def at(self, key: str | int, value: Yaml) -> Field:
        """Give a value below this one."""
        return Field(self.document, (*self.path, key), value, self.remedy)

    def names(self) -> dict[str, Yaml]:
        """Give the named values below this one.

        Raises
        ------
        InputError
            It has none: it is no mapping.
        """
        if not isinstance(self.value, dict):
            raise self.error(f"is {shown(self.value)}, not named values")
        return self.value

    def child(self, name: str) -> Field:
        """Give a named value below this one.

        Raises
        ------
        InputError
            There is none of that name.
        """
        names = self.names()
        if name not in names:
            raise self.at(name, None).error("is missing")
        return self.at(name, names[name])

    def items(self) -> list[Field]:
        """Give the values of a list.

        Raises
        ------
        InputError
            It is no list.
        """
        if not isinstance(self.value, list):
            raise self.error(f"has to be a list of numbers, not {shown(self.value)}")
        return [self.at(index, value) for index, value in enumerate(self.value)]

    def number(self, limit: float = MAX_MAGNITUDE) -> float:
        """Give a finite number of at most `limit`.

        Raises
        ------
        InputError
            It is text, not finite, or larger.
        """
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(f"is {shown(value)}, not a number")
        # Written this way round, NaN fails too.
        if not abs(value) <= limit:
            raise self.error(
                f"is {shown(value)}, which no rig has", remedy="calibrate again or correct it"
            )
        return float(value)

    def numbers(self, limit: float = MAX_MAGNITUDE) -> Array:
        """Give a list's finite numbers (n,), of at most `limit` each.

        Raises
        ------
        InputError
            It is no list, or something in it is no finite number.
        """
        return np.array([item.number(limit) for item in self.items()], dtype=np.float64)

    def rows(self, shape: tuple[int, int]) -> Array:
        """Give a matrix written as a list of rows.

        Raises
        ------
        InputError
            It is no list of rows, of another shape, or something in it is no finite number.
        """
        rows = [item.numbers() for item in self.items()]
        if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
            wanted = " x ".join(map(str, shape))
            raise self.error(f"is no {wanted} matrix", remedy=f"give {wanted} as a list of rows")
        return np.array(rows)

    def text(self) -> str:
        """Give text.

        Raises
        ------
        InputError
            It is something else.
        """
        if not isinstance(self.value, str):
            raise self.error(f"is {shown(self.value)}, not text")
        return self.value

    def side(self) -> int:
        """Give an image's width or height, px.

        Raises
        ------
        InputError
            It is no whole number, or out of range.
        """
        value = self.value
        # Written from a C++ double, a size reads "2048.".
        number = -1 if isinstance(value, bool) or not isinstance(value, int | float) else value
        if 1 <= number <= MAX_SIDE and number == int(number):
            return int(number)
        raise self.error(
            f"is {shown(value)}", remedy=f"give a whole number of px from 1 to {MAX_SIDE}"
        )

    def sides(self) -> tuple[int, int]:
        """Give an image's [width, height], px.

        Raises
        ------
        InputError
            It is no list of two sides.
        """
        if not isinstance(self.value, list) or len(self.value) != 2:
            raise self.error(f"is {shown(self.value)}", remedy="give [width, height], px")
        width, height = self.items()
        return width.side(), height.side()
