"""Shot noise: Poisson numbers of electrons, fast for any mean.

A standard normal w and a uniform u belong to every value, so a pixel's noise depends on its place
and its own light only, and more light on one pixel disturbs no other.

From `TABLE_BELOW_E` electrons on, w goes through the quantile function of the Poisson
distribution, expanded in powers of 1/sqrt(mu) (Giles 2016, "Algorithm 955", ACM TOMS 42:7), and is
rounded down. The distribution is within 1.3e-5 of Poisson's in total variation at 32 e-, 1.2e-6
at 100 e-, 1.2e-8 at 1000 e-; its mean within 1e-9 e-; its variance within 3e-5 of mu.

Below, mu is split: mu = k / 16 + delta. The sum of two independent Poisson numbers is Poisson, so

- one with the mean k / 16 comes from w by inversion: it is the count of thresholds
  ``Phi^-1(P(n; k / 16))`` below w. A table has, for every k and every eighth of w, the count at the
  lower end and the one threshold within (they are more than 1/8 apart for all means below 32).
- one with the mean delta < 1/16 comes from u by inversion; u < delta is rare, the rest is zero.

Both are exact but for single precision: w and u are multiples of about 2^-22 and of 2^-24, which
changes the probability of any number by less than 1e-6 and the mean by less than 3e-7 e-.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from simtip.sensor.real import Array, Real

TABLE_BELOW_E = 32.0
"""Means below this many electrons use the table."""

_PER_E = 16  # rows of the table per electron
_PER_W = 8  # columns per standard deviation
_W_END = 8.0  # beyond, a chance of 1e-15, the neighbouring row's end is used
_COLUMNS = int(2 * _W_END * _PER_W)


def shot_noise(mean_e: NDArray[Real], rng: np.random.Generator) -> NDArray[Real]:
    """Draw Poisson numbers of electrons.

    In single precision, rounding adds at most mu 2^-24 electrons on average, 6e-4 e- at 10,000 e-.

    Parameters
    ----------
    mean_e
        mu_e, any shape, e-, finite and at least 0.
    rng
        Consumed: spawns two streams, of a normal and of a uniform number for every value.

    Returns
    -------
    electrons
        Same shape and type, whole numbers.
    """
    normals, uniforms = rng.spawn(2)
    return draw(mean_e, normals, uniforms)


def draw(
    mean_e: NDArray[Real], normals: np.random.Generator, uniforms: np.random.Generator
) -> NDArray[Real]:
    """Draw as `shot_noise`, from streams already spawned."""
    w = normals.standard_normal(mean_e.shape, dtype=mean_e.dtype)
    u = uniforms.random(mean_e.shape, dtype=np.float32)
    return poisson_quantile(mean_e, w, u)


def poisson_quantile(
    mean_e: NDArray[Real], w: NDArray[Real], u: NDArray[np.float32]
) -> NDArray[Real]:
    """Turn a standard normal and a uniform number into a Poisson number, see the module.

    Parameters
    ----------
    mean_e
        mu, e-, finite and at least 0.
    w, u
        Standard normal, and uniform in [0, 1), of the same shape.
    """
    few = mean_e < TABLE_BELOW_E
    if few.all():
        return _by_table(mean_e, w, u)
    drawn = _by_expansion(mean_e, w)
    if few.any():
        drawn[few] = _by_table(mean_e[few], w[few], u[few])
    return drawn


def _by_expansion(mean_e: NDArray[Real], w: NDArray[Real]) -> NDArray[Real]:
    mu = np.maximum(mean_e, TABLE_BELOW_E)
    w2 = w * w
    root = np.sqrt(mu)
    first = w2 * (1 / 6) + 1 / 3
    second = w * (w2 * (1 / 72) + 1 / 36)
    third = (w2 * (1 / 270) + 7 / 810) * w2 - 8 / 405
    drawn = np.floor(mu + (root * w + (first + (third / root - second) / root)))
    return np.maximum(drawn, 0)


def _by_table(mean_e: NDArray[Real], w: NDArray[Real], u: NDArray[np.float32]) -> NDArray[Real]:
    below, threshold = _table()
    row = np.floor(mean_e * _PER_E)
    column = np.floor(w * _PER_W)  # both exact: factors are powers of two
    column += _COLUMNS / 2
    column += row * _COLUMNS
    cell = column.astype(np.intp)
    count = below.take(cell, mode="clip")
    count += w > threshold.take(cell, mode="clip")
    drawn = count.astype(mean_e.dtype)
    row /= _PER_E
    rest = np.subtract(mean_e, row, out=row)
    some = np.flatnonzero(u < rest)
    drawn.reshape(-1)[some] += _few(rest.ravel()[some].astype(np.float64), u.ravel()[some])
    return drawn


def _few(mean_e: Array, u: NDArray[Any]) -> NDArray[Any]:
    """Invert the Poisson distribution for means below 1/16: u less than P(at least n) counts."""
    term = np.exp(-mean_e)
    at_least = -np.expm1(-mean_e)
    count = np.zeros(mean_e.shape)
    for n in range(1, 6):
        count += u < at_least
        term = term * mean_e / n
        at_least = at_least - term
    return count


@cache
def _table() -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Give, flat by row and column, the count below a column and the threshold in it or inf."""
    mean = np.arange(int(TABLE_BELOW_E) * _PER_E)[:, None] / _PER_E
    n = np.arange(128)
    lower, upper = special.pdtr(n, mean), special.pdtrc(n, mean)
    thresholds = np.where(lower < 0.5, special.ndtri(lower), -special.ndtri(upper))
    ends = np.arange(_COLUMNS + 1) / _PER_W - _W_END
    counts = np.stack([np.searchsorted(each, ends) for each in thresholds])
    inside = np.take_along_axis(thresholds, counts[:, :-1], axis=1)
    inside = np.where(np.diff(counts, axis=1) > 0, inside, np.inf)
    return counts[:, :-1].astype(np.uint8).ravel(), inside.astype(np.float32).ravel()
