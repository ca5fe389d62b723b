"""Fit the needle's shaft: axis, width and blur, from all pixels near its two edges.

Steps are Levenberg and Marquardt's, the first ones on merged pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_equations import TRUSTED, equations_of
from simtip.detect.subpixel.shaft_pixels import Bins, block_rows, merge, noise_of, sort_pixels
from simtip.geometry import Array

FIRST_STEPS, LAST_STEPS = 8, 20

SETTLED = 0.05
"""Change of the cost, a log likelihood times -2, over the misfit at which the fit ends."""

FIRST_MISFIT = 12.0
"""A shaft that fits so well after the first start's steps is not looked for from others."""

LEAST_VARIANCE_PX2 = 0.003

FAILED_DAMPING = 0.01
"""At least so much after a step that failed: less would try the same step again."""


def fit(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
) -> Shaft:
    """Fit a shaft to rows of the turned gray image (H, W).

    Parameters
    ----------
    image
        Gray values, turned.
    rows
        Consecutive rows; those beyond whole blocks are dropped at the front.
    starts
        Shafts good to a pixel, of different blur. A few steps are taken from each; the best of
        those goes on.
    likely
        Says of a shaft whether it can be; if none can, the width is held where the starts have it.
    """
    rows = rows[len(rows) % block_rows(rows) :]
    noise = noise_of(image, rows, starts[0])
    free = [replace(start, noise=noise) for start in starts]
    best = _best_of(image, rows, free, likely)
    if best is not None:
        ended = _settled(sort_pixels(image, rows, best), best, LAST_STEPS)
        if likely(ended):
            return ended
    held = [replace(start, width_held=True) for start in free]
    best = _best_of(image, rows, held, lambda _: True) or held[0]
    return _settled(sort_pixels(image, rows, best), best, LAST_STEPS)


def _best_of(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
) -> Shaft | None:
    """Take the first steps from starts, until from one they lead to a likely shaft that fits."""
    tried = []
    for start in starts:
        one = _first_settled(sort_pixels(image, rows, start), start)
        if likely(one):
            tried.append(one)
            if one.misfit < FIRST_MISFIT:
                break
    return min(tried, key=lambda one: one.cost, default=None)


def _first_settled(bins: Bins, start: Shaft) -> Shaft:
    """Take the first steps; with blocks and bins merged, if the shaft is so even that it can be."""
    merged = _settled(merge(bins), start, FIRST_STEPS)
    return merged if merged.misfit < FIRST_MISFIT else _settled(bins, start, FIRST_STEPS)


def _settled(bins: Bins, start: Shaft, most: int) -> Shaft:
    """Step to the least cost (Levenberg and Marquardt)."""
    best, found = start, equations_of(bins, start)
    damping = 1e-3
    for _ in range(most):
        step, promised = found.step(damping, best.variance - LEAST_VARIANCE_PX2)
        # A bad block's misfit counts little in the cost.
        enough = SETTLED * max(1.0, found.misfit / (1 + found.misfit / TRUSTED))
        if promised < enough:
            break
        tried = _moved(best, step)
        there = equations_of(bins, tried)
        if not there.cost < found.cost:
            damping = max(damping * 10, FAILED_DAMPING)
            if damping > 1e4:
                break
            continue
        settled = found.cost - there.cost < enough
        best, found = tried, there
        damping = max(damping / 10, 1e-6)
        if settled:
            break
    return replace(
        best,
        covariance=found.covariance(),
        misfit=found.misfit,
        cost=found.cost,
        shared=found.shared,
    )


def _moved(shaft: Shaft, step: Array) -> Shaft:
    a = len(shaft.axis)
    b = a + len(shaft.width)
    return replace(
        shaft,
        axis=shaft.axis + step[:a],
        width=shaft.width + step[a:b],
        variance=np.maximum(shaft.variance + step[b:], LEAST_VARIANCE_PX2),
    )
