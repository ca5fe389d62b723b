"""Gaussian random fields whose values belong to places, whatever part of them is asked for.

White noise sits on a lattice of its own, drawn tile by tile from named streams; a Gaussian kernel
makes a smooth field of it, taken where the texels are. So neither the box nor the order matters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.clutter.grid import Grid
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.seeding import stream

Field32 = NDArray[np.float32]

TILE = 256
"""Lattice points along a tile's side."""

REACH = 4.5
"""The kernel ends after so many sigma, where it has 4e-5 of its height."""

MAX_LATTICE = 100_000_000
"""Lattice points: 400 MB."""


@dataclass(frozen=True)
class Axis:
    """The kernel along one axis: texel k is ``weights[k] @ lattice[first:]``."""

    first: int
    weights: scipy.sparse.csr_array


def kernel(centres: Array, step: float, sigma: float, *, area: bool, order: int = 0) -> Axis:
    """Build the weights along one axis.

    Parameters
    ----------
    centres, step
        Of the texels, (count,) mm and mm.
    sigma
        Of the kernel, mm, and the lattice's spacing: the variance then ripples by 1e-4 at most.
    area
        Mean over the texel (which adds a twelfth of its square to sigma's) or value at its centre.
    order
        0 for the field, 1 for its derivative, per mm.
    """
    wide = math.hypot(sigma, step / math.sqrt(12)) if area else sigma
    reach = math.ceil(REACH * wide / sigma)
    nearest = np.rint(centres / sigma).astype(np.int64)
    taps = nearest[:, None] + np.arange(-reach, reach + 1)
    x = (centres[:, None] - taps * sigma) / wide
    # Unit variance of the unwidened field: the sum of squares is sqrt(pi) lattice steps.
    weights = np.exp(-(x**2) / 2) / math.sqrt(math.sqrt(math.pi)) * (sigma / wide)
    if order == 1:
        weights *= -x / wide
    first = int(taps[0, 0])
    start = np.arange(len(centres) + 1) * taps.shape[1]
    columns = (taps - first).ravel()
    shape = (len(centres), int(taps[-1, -1]) - first + 1)
    values = weights.astype(np.float32).ravel()
    return Axis(first, scipy.sparse.csr_array((values, columns, start), shape))


def field(
    seed: int, name: str, grid: Grid, correlation_mm: float, *, slopes: bool = False
) -> Field32:
    """Give a field of mean 0 and variance 1, whose autocorrelation is ``exp(-(d / L)^2)``.

    Parameters
    ----------
    seed, name
        Which field.
    grid
        The texels.
    correlation_mm
        L, where the autocorrelation has fallen to 1/e.
    slopes
        Give the derivatives along s and t, per mm, at the texels' centres instead. The mean square
        of their magnitude is ``4 / L^2``.

    Returns
    -------
    field
        (rows, cols), each the mean over its texel; or slopes (rows, cols, 2).

    Raises
    ------
    InputError
        The grain is so fine, or the board so large, that memory would not hold it.
    """
    sigma = correlation_mm / 2
    s, t = grid.axes()
    orders = ((0, 1), (1, 0)) if slopes else ((0, 0),)  # (along t, along s)
    down = [kernel(t, grid.step_mm, sigma, area=not slopes, order=o) for o, _ in orders]
    over = [kernel(s, grid.step_mm, sigma, area=not slopes, order=o) for _, o in orders]
    height, width = down[0].weights.shape[1], over[0].weights.shape[1]
    if height * width > MAX_LATTICE:
        raise InputError(
            f"{np.ptp(s):.0f} x {np.ptp(t):.0f} mm of the board are seen, and "
            f"grain of {correlation_mm:g} mm on them is too much to hold",
            field="background",
            remedy="make size_mm smaller or the correlation length larger",
        )
    noise = white(seed, name, down[0].first, over[0].first, (height, width))
    found = [(x.weights @ (y.weights @ noise).T).T for y, x in zip(down, over, strict=True)]
    values = np.stack(found, axis=-1) if slopes else found[0]
    return np.ascontiguousarray(values, dtype=np.float32)


def white(seed: int, name: str, row: int, col: int, shape: tuple[int, int]) -> Field32:
    """Give standard normal numbers (shape) of the lattice points from (row, col) on."""
    noise = np.empty(shape, dtype=np.float32)
    for j in range(row // TILE, (row + shape[0] - 1) // TILE + 1):
        for i in range(col // TILE, (col + shape[1] - 1) // TILE + 1):
            rng = stream(seed, "board", name, j, i)
            tile = rng.standard_normal((TILE, TILE), dtype=np.float32)
            y, x = j * TILE - row, i * TILE - col
            into = noise[max(y, 0) : y + TILE, max(x, 0) : x + TILE]
            h, w = into.shape
            into[:] = tile[max(-y, 0) : max(-y, 0) + h, max(-x, 0) : max(-x, 0) + w]
    return noise
