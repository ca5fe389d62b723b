"""Brightness across a round needle: a smooth function of the angle of its surface.

The angle w is that to the line of sight's tangent, 0 at an edge of the outline. A constant and a
Gaussian process over w, even and odd about the needle's middle. Right at the edges rough metal
mirrors what is behind the needle, the same at both: the process is 0 there.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from simtip.geometry import Array

LENGTH_RAD = 0.2
"""Over which the brightness changes: what roughness leaves of the surroundings."""

ALIKE_RAD = 0.3
"""Over which the process comes to half its variance's root."""

TIP_ALIKE_RAD = 0.5
"""Likewise for what a tip's brightness differs from the shaft's: near the edges they are alike, for
there both mirror the same."""

EVEN, ODD = 9, 9
TIP_EVEN, TIP_ODD = 6, 5
"""Modes, the constant not counted."""

MODES = 1 + EVEN + ODD
TIP_MODES = 1 + TIP_EVEN + TIP_ODD

NODES = 1024
"""Steps of the angle, over half a turn, in tables."""

_GRID = 128


@lru_cache(maxsize=1)
def nodes() -> Array:
    """Give s, the place across from -1 to 1, at the nodes (NODES + 1,): sines of equal steps."""
    return np.asarray(np.sin(np.linspace(-np.pi / 2, np.pi / 2, NODES + 1)))


@lru_cache(maxsize=1)
def tables() -> Array:
    """Give the integral over s from -1 to the nodes of each mode (MODES, NODES + 1).

    The constant, the even ones, the odd ones, the most usual first; their amplitudes have unit
    variance.
    """
    return _tables(lambda w: w / (w + ALIKE_RAD), EVEN, ODD)


@lru_cache(maxsize=1)
def tip_tables() -> Array:
    """Give the same of a tip's difference from the shaft (TIP_MODES, NODES + 1)."""
    return _tables(lambda w: 1 - np.exp(-0.5 * (w / TIP_ALIKE_RAD) ** 2), TIP_EVEN, TIP_ODD)


def _tables(fade: Callable[[Array], Array], even: int, odd: int) -> Array:
    w = (np.arange(_GRID) + 0.5) / _GRID * np.pi / 2
    kernel = np.exp(-0.5 * ((w[:, None] - w) / LENGTH_RAD) ** 2)
    values, vectors = np.linalg.eigh(fade(w)[:, None] * kernel * fade(w))
    best = vectors[:, ::-1] * np.sqrt(np.maximum(values[::-1], 0))
    theta = (np.arange(NODES) + 0.5) / NODES * np.pi - np.pi / 2
    away = np.pi / 2 - np.abs(theta)
    knots = np.concatenate([[0.0], w])
    shapes = np.stack([np.interp(away, knots, np.append(0.0, column)) for column in best.T])
    modes = np.concatenate([np.ones((1, NODES)), shapes[:even], shapes[:odd] * np.sign(theta)])
    sums = np.cumsum(modes * np.diff(nodes()), axis=1)
    return np.concatenate([np.zeros((len(modes), 1)), sums], axis=1)
