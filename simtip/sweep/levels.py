"""The values of factors, and points spread over them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.geometry import Array
from simtip.seeding import stream
from simtip.sweep.spec import RangeSpec, SampledSpec

HALF_STEP = 1e-9
"""Part of a step by which rounding may make a range's last value miss its end."""


@dataclass(frozen=True)
class Dimension:
    """Fields that vary together.

    Attributes
    ----------
    paths
        Fields of the scene.
    levels
        Of each level, the fields' values, in this order; none if any value within `span` may be.
    span
        A range to be sampled.
    whole
        Whether the field takes whole numbers only.
    """

    paths: tuple[str, ...]
    levels: tuple[tuple[Any, ...], ...]
    span: RangeSpec | None = None
    whole: bool = False

    def at(self, share: float) -> tuple[Any, ...]:
        """Give the values at a point from 0 to below 1."""
        if self.span is None:
            return self.levels[min(int(share * len(self.levels)), len(self.levels) - 1)]
        if self.whole:
            first, last = int(np.ceil(self.span.low)), int(np.floor(self.span.high))
            return (first + min(int(share * (last - first + 1)), last - first),)
        return (_between(self.span, share),)


def _between(span: RangeSpec, share: float) -> float:
    if span.log:
        return float(span.low * (span.high / span.low) ** share)
    return float(span.low + share * (span.high - span.low))


def values_of(span: RangeSpec, *, whole: bool) -> tuple[float | int, ...]:
    """Give a range's evenly spaced values; for a field of whole numbers rounded, each once."""
    if span.step is not None:
        count = int(np.floor((span.high - span.low) / span.step + HALF_STEP)) + 1
        values = [span.low + k * span.step for k in range(count)]
    elif span.count is None:
        raise ValueError("a range without values")
    else:
        values = [_between(span, k / (span.count - 1)) for k in range(span.count)]
        values[-1] = span.high
    # 0.1 + 2 * 0.1 is 0.3, as people write it.
    tidy = [float(f"{value:.12g}") for value in values]
    return tuple(dict.fromkeys(round(value) if whole else value for value in tidy))


def points(design: SampledSpec, dimensions: int) -> Array:
    """Spread points over a unit cube.

    Returns
    -------
    points
        (n, dimensions), 0 to below 1; the same for the same design on every machine. The first m
        of n points are those of m points for "random" and "sobol".
    """
    from scipy.stats import qmc

    rng = stream(design.seed, "sweep design", design.kind)
    if dimensions == 0:
        return np.zeros((design.points, 0))
    if design.kind == "random":
        return rng.random((design.points, dimensions))
    if design.kind == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(design.points))
    with warnings.catch_warnings():
        # Not only powers of two are asked for; the balance that others lack is not needed.
        warnings.filterwarnings("ignore", message="The balance properties", category=UserWarning)
        return np.asarray(qmc.Sobol(dimensions, scramble=True, rng=rng).random(design.points))


def mixed_radix(number: int, sizes: Sequence[int]) -> list[int]:
    """Write a number in digits of these bases, the last the quickest."""
    digits = []
    for size in reversed(sizes):
        number, digit = divmod(number, size)
        digits.append(digit)
    return digits[::-1]
