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
from simtip.detect.subpixel.shaft_noise import noise_of
from simtip.detect.subpixel.shaft_pixels import Bins, block_rows, merge, sort_pixels
from simtip.geometry import Array

FIRST_STEPS, LAST_STEPS = 8, 20

SETTLED, SEEN = 0.05, 1.0
"""Change of the cost, a log likelihood times -2, over the misfit at which the fit ends, and a look
at it."""

FIRST_MISFIT, BLURRED_MISFIT, SHARP_PX2 = 12.0, 2.0, 0.2
"""A shaft that fits so well after the first start's steps is taken, the former if it is so sharp:
in a blurred picture the kinds of blur have to be told apart."""

HALVED_STEPS = 3
"""Of a shaft on half its rows, to see whether it fits those better."""

RACE = ((2, 6), (2, 3), (2, 2))
"""Rounds of the race of starts on merged pixels: steps of each, and how many go on."""

LEAST_VARIANCE_PX2 = 0.003

VAIN = 40
"""A fit ends, too, at a step that failed and promised less than so many times that: weights and
tables change with the shaft, and the cost is no smoother."""

FAILED_DAMPING = 0.01
"""At least so much after a step that failed: less would try the same step again."""


def fit(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
    seen: Shaft | None = None,
    *,
    any_width: bool = False,
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
    seen
        What a glance from the first start made of these rows.
    any_width
        Take the best one if none is likely, whatever its width.
    """
    rows = _whole_blocks(rows)
    noise = noise_of(image, rows, starts[0]) if seen is None else seen.noise
    free = [replace(start, noise=noise) for start in starts]
    if seen is not None and fits(seen) and likely(seen):
        best: Shaft | None = seen
    else:
        best = _best_of(image, rows, [seen or free[0], *free[1:]], likely)
    if best is not None:
        ended = _settled(sort_pixels(image, rows, best), best, LAST_STEPS)
        if likely(ended):
            return ended
    held = free if any_width else [replace(start, width_held=True) for start in free]
    best = _best_of(image, rows, held, lambda _: True) or held[0]
    return _settled(sort_pixels(image, rows, best), best, LAST_STEPS)


def glance(image: NDArray[np.float32], rows: NDArray[np.intp], start: Shaft) -> Shaft:
    """Take the first steps from one start, on merged pixels."""
    rows = _whole_blocks(rows)
    known = replace(start, noise=noise_of(image, rows, start))
    return _settled(merge(sort_pixels(image, rows, known)), known, FIRST_STEPS, SEEN)


def halved(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Shaft:
    """Take a shaft's next steps on some of its rows alone."""
    rows = _whole_blocks(rows)
    return _settled(sort_pixels(image, rows, shaft), shaft, HALVED_STEPS, SEEN)


def is_sharp(shaft: Shaft) -> bool:
    """Say whether it is hardly blurred."""
    return bool(shaft.variance.max() < SHARP_PX2)


def fits(shaft: Shaft) -> bool:
    """Say whether it describes its pixels so well that no other blur needs to be tried."""
    return bool(shaft.misfit < (FIRST_MISFIT if is_sharp(shaft) else BLURRED_MISFIT))


def _whole_blocks(rows: NDArray[np.intp]) -> NDArray[np.intp]:
    return rows[len(rows) % block_rows(rows) :]


def _best_of(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    starts: list[Shaft],
    likely: Callable[[Shaft], bool],
) -> Shaft | None:
    """Take the first steps from starts, and give the likely shaft to which the best of them lead.

    The first start's is taken at once if it fits, and is sharp: only blurs have to be told apart.
    """
    bins = sort_pixels(image, rows, starts[0])
    merged = merge(bins)
    first = _settled(merged, starts[0], FIRST_STEPS, SEEN)
    if is_sharp(first) and not fits(first):
        first = _settled(bins, starts[0], FIRST_STEPS)
    if fits(first) and likely(first):
        return first
    tried = [
        _settled(bins, one, FIRST_STEPS) for one in _winners(merged, [first, *starts[1:]], likely)
    ]
    return min((one for one in tried if likely(one)), key=lambda one: one.cost, default=None)


def _winners(merged: Bins, field: list[Shaft], likely: Callable[[Shaft], bool]) -> list[Shaft]:
    """Let starts take steps, the worse ones fewer; those that can be are before all others."""
    for steps, kept in RACE:
        field = [_settled(merged, one, steps) for one in field]
        field = sorted(field, key=lambda one: (not likely(one), one.cost))[:kept]
    return [one for one in field if likely(one)]


def _settled(bins: Bins, start: Shaft, most: int, settled_at: float = SETTLED) -> Shaft:
    """Step to the least cost (Levenberg and Marquardt)."""
    best, found = start, equations_of(bins, start)
    damping = 1e-3
    for _ in range(most):
        step, promised = found.step(damping, best.variance - LEAST_VARIANCE_PX2)
        # A bad block's misfit counts little in the cost.
        enough = settled_at * max(1.0, found.misfit / (1 + found.misfit / TRUSTED))
        if promised < enough:
            break
        tried = _moved(best, step)
        there = equations_of(bins, tried)
        if not there.cost < found.cost:
            damping = max(damping * 10, FAILED_DAMPING)
            if damping > 1e4 or promised < VAIN * enough:
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
