"""Lin's concordance correlation coefficient."""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from simtip.capability.interval import Interval, paired, spread
from simtip.capability.regression import correlation, fisher_interval


@dataclass(frozen=True)
class Concordance:
    """Lin's coefficient, and its parts: ccc = r x accuracy.

    Attributes
    ----------
    ccc, ccc_ci
        The coefficient, moments over n as Lin has them, and its interval by Fisher's Z; the
        interval is None below three pairs, or if the correlation is 0.
    bias_correction
        C_b: how far the best line is from the identity, 1 at best.
    """

    ccc: float
    ccc_ci: Interval | None
    bias_correction: float


def concordance(measured: ArrayLike, reference: ArrayLike, level: float = 0.95) -> Concordance:
    """Give Lin's concordance correlation (1989), its variance as corrected in 2000.

    Parameters
    ----------
    measured, reference
        (n,) each, n at least 2.

    Raises
    ------
    ValueError
        There are too few values, lengths differ, a number is not finite, or one of the two does
        not vary.
    """
    y, x = paired(measured, reference, 2)
    r = correlation(y, x)
    if r is None:
        raise ValueError("no concordance: all measured, or all reference, values are equal")
    n = len(x)
    shrink = (n - 1) / n
    sy, sx = (spread(v) * math.sqrt(shrink) for v in (y, x))
    shift = float(y.mean() - x.mean())
    correction = 2 * sx * sy / (sx**2 + sy**2 + shift**2)
    ccc = r * correction
    return Concordance(ccc, _interval(ccc, r, shift**2 / (sx * sy), n, level), correction)


def _interval(ccc: float, r: float, u2: float, n: int, level: float) -> Interval | None:
    """Take Z's variance from Lin (2000), u2 being the squared location shift."""
    if n < 3 or r == 0:
        return None
    if abs(ccc) >= 1:
        return Interval(ccc, ccc)
    rest = 1 - ccc**2
    variance = (1 - r**2) * ccc**2 / (rest * r**2)
    variance += 2 * ccc**3 * (1 - ccc) * u2 / (r * rest**2)
    variance -= ccc**4 * u2**2 / (2 * r**2 * rest**2)
    return fisher_interval(ccc, math.sqrt(max(variance, 0) / (n - 2)), level)
