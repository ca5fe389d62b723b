"""Lengths as plots write them: small ones in um, and with the decimals that tell them apart."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

MICRO = "\N{MICRO SIGN}m"
MINUS = "\N{MINUS SIGN}"

SMALL_MM = 0.1
"""Millimetres below this are shown as micrometres."""

LEAST = 1e-9
"""What is smaller, in the unit of the data or shown, is rounding, and drawn as 0."""

ALIKE = 1e-6
"""Values that differ by less than this share of them are drawn as equal ones."""


@dataclass(frozen=True)
class Scale:
    """How one axis shows lengths.

    Attributes
    ----------
    factor
        Units shown for one unit of the data.
    unit
        Its name.
    decimals
        Of numbers in texts: three digits of the largest.
    """

    factor: float
    unit: str
    decimals: int

    def of(self, values: ArrayLike) -> Array:
        """Give lengths in the unit shown."""
        return self.factor * np.asarray(values, dtype=np.float64)

    def number(self, value: float) -> str:
        """Write a length without its unit."""
        return number(self.factor * value, self.decimals)

    def text(self, value: float) -> str:
        """Write a length with its unit."""
        return f"{self.number(value)} {self.unit}"

    def between(self, low: float, high: float) -> str:
        """Write an interval without its unit."""
        return f"[{self.number(low)}, {self.number(high)}]"


def scale_for(values: ArrayLike, unit: str = "mm") -> Scale:
    """Choose the scale by the largest size of values (n,); only mm have a smaller unit."""
    most = float(np.abs(values).max())
    factor, shown = (1e3, MICRO) if unit == "mm" and most < SMALL_MM else (1.0, unit)
    return Scale(factor, shown, digits(factor * most) if most > LEAST else 0)


def digits(value: float) -> int:
    """Tell the decimals that write a value above 0 with three digits."""
    return max(0, 2 - math.floor(math.log10(value)))


def number(value: float, decimals: int) -> str:
    """Write a number; what rounds to 0 has no sign."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", MINUS)


def limits(values: ArrayLike, *, margin: float = 0.06) -> tuple[float, float]:
    """Give ends of an axis that holds all values, in the unit shown, with a margin at both.

    Around equal values it holds a tenth of them to both sides, around 0 one unit.
    """
    low, high = float(np.min(values)), float(np.max(values))
    most = max(abs(low), abs(high))
    if high - low <= max(ALIKE * most, LEAST):
        room = 0.1 * most if most > LEAST else 1.0
    else:
        room = margin * (high - low)
    return low - room, high + room
