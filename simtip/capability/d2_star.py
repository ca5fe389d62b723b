"""The factors that turn mean ranges of normal samples into standard deviations.

d2* = sqrt(d2^2 + d3^2 / g) for g samples of m (Duncan, Quality Control and Industrial Statistics;
Patnaik 1950): what AIAG MSA tabulates in appendix C. Computed here, not looked up.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy import special

MANY = 15
"""Of more samples than these AIAG takes d2 itself."""

LIMIT = 9.0
"""Beyond so many standard deviations nothing is left of a normal population."""


@cache
def range_moments(m: int) -> tuple[float, float]:
    """Give the mean d2 and the standard deviation d3 of the range of m standard normal values.

    Raises
    ------
    ValueError
        m is below 2: one value has no range.
    """
    if m < 2:
        raise ValueError(f"the range of {m} values does not exist: at least 2 are needed")
    nodes, weights = np.polynomial.legendre.leggauss(400)
    x = LIMIT * nodes
    wx = LIMIT * weights
    # The smallest lies at x: the others between it and x + w.
    w, ww = LIMIT * (nodes + 1), LIMIT * weights
    between = special.ndtr(x[:, None] + w) - special.ndtr(x)[:, None]
    density = np.exp(-(x**2) / 2) / math.sqrt(2 * math.pi)
    above = 1 - m * (wx * density) @ between ** (m - 1)
    mean, square = float(ww @ above), float(2 * (ww * w) @ above)
    return mean, math.sqrt(square - mean**2)


def d2_star(m: int, g: int) -> float:
    """Give d2* of g samples of m values; d2 if there are more than `MANY` samples.

    Raises
    ------
    ValueError
        m is below 2 or g below 1.
    """
    if g < 1:
        raise ValueError(f"{g} samples have no mean range")
    d2, d3 = range_moments(m)
    return d2 if g > MANY else math.sqrt(d2**2 + d3**2 / g)
