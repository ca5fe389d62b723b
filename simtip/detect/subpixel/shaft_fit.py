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

FIRST_MISFIT, BLURRED_MISFIT, SHARP_PX2, SOFT_PX2 = 12.0, 2.5, 0.2, 1.0
"""A shaft that fits so well after the first start's steps is taken, the former if it is so sharp,
the latter if it is not so soft: in a blurred picture the kinds of blur have to be told apart."""

HALVED_STEPS = 3
"""Of a shaft on half its rows, to see whether it fits those better."""

RACE = ((2, 4), (2, 3), (2, 2))
"""Rounds of the race of starts on merged pixels: steps of each, and how many go on."""

SAME_PX, SAME_COST, SAME_SHARE = 0.05, 20.0, 0.05
"""Shafts of a race so near to each other, in px and px^2, and in cost, or by its share, are one."""

STUCK = 100.0
"""Times the best one's misfit, or 1: a shaft that fits so badly has got nowhere."""

LEAST_VARIANCE_PX2 = 0.003

LEAST_SHARE, MOST_SHARE = 0.2, 0.98
"""Of the blur, what may be a disc's; less is none."""

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
        ended = _ended(image, rows, best)
        if likely(ended):
            return ended
    held = free if any_width else [replace(start, width_held=True) for start in free]
    best = _best_of(image, rows, held, lambda _: True) or held[0]
    return _ended(image, rows, best)


def _ended(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> Shaft:
    """Fit a shaft to the end; of a disc that is hardly there only the variance is seen."""
    ended = _settled(sort_pixels(image, rows, shaft), shaft, LAST_STEPS, share=_tells_kind(shaft))
    return ended if ended.disc_share > LEAST_SHARE else replace(ended, disc_share=0.0)


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


def _tells_kind(shaft: Shaft) -> bool:
    """Say whether a shaft is blurred, and fits so well that it tells a disc from a Gaussian."""
    return not is_sharp(shaft) and shaft.misfit < TRUSTED


def fits(shaft: Shaft) -> bool:
    """Say whether it describes its pixels so well that no other blur needs to be tried."""
    soft = bool(shaft.variance.max() > SOFT_PX2)
    return not soft and bool(shaft.misfit < (FIRST_MISFIT if is_sharp(shaft) else BLURRED_MISFIT))


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
    if _tells_kind(first):
        first = _settled(merged, first, FIRST_STEPS, SEEN, share=True)
    if fits(first) and likely(first):
        return first
    tried = [
        _settled(bins, one, FIRST_STEPS, share=_tells_kind(one))
        for one in _winners(merged, [first, *starts[1:]], likely)
    ]
    return min((one for one in tried if likely(one)), key=lambda one: one.cost, default=None)


def _winners(merged: Bins, field: list[Shaft], likely: Callable[[Shaft], bool]) -> list[Shaft]:
    """Let starts take steps, the worse ones fewer; those that can be are before all others."""
    for steps, kept in RACE:
        field = [_settled(merged, one, steps) for one in field]
        field = _apart(sorted(field, key=lambda one: (not likely(one), one.cost)))[:kept]
    most = STUCK * max(1.0, min(one.misfit for one in field))
    return [one for one in field if likely(one) and one.misfit < most]


def _apart(field: list[Shaft]) -> list[Shaft]:
    """Give shafts without those that have come to where a better one is, which is before them."""
    kept: list[Shaft] = []
    for one in field:
        if not any(_same(one, other) for other in kept):
            kept.append(one)
    return kept


def _same(one: Shaft, other: Shaft) -> bool:
    """Say whether two shafts on their way are as good as one."""
    off_px = abs(one.width[0] - other.width[0]) + abs(one.axis[0] - other.axis[0])
    off_px2 = np.abs(one.variance - other.variance).max()
    near = one.cost - other.cost < max(SAME_COST, SAME_SHARE * other.cost)
    return bool(off_px < SAME_PX and off_px2 < SAME_PX and near)


def _settled(
    bins: Bins, start: Shaft, most: int, settled_at: float = SETTLED, *, share: bool = False
) -> Shaft:
    """Step to the least cost (Levenberg and Marquardt); with `share`, that of the disc is free."""
    best, found = start, equations_of(bins, start, share=share)
    damping = 1e-3
    for _ in range(most):
        step, promised = found.step(damping, *_room(best, share=share))
        # A bad block's misfit counts little in the cost.
        enough = settled_at * max(1.0, found.misfit / (1 + found.misfit / TRUSTED))
        if promised < enough:
            break
        tried = _moved(best, step)
        there = equations_of(bins, tried, share=share)
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
        variance=np.maximum(shaft.variance + step[b : b + 2], LEAST_VARIANCE_PX2),
        disc_share=_share(shaft, step[b + 2 :]),
    )


def _share(shaft: Shaft, step: Array) -> float:
    """Give the disc's share after a step (1,) of its square, or without one."""
    if not len(step):
        return shaft.disc_share
    return float(np.sqrt(np.clip(shaft.disc_share**2 + step[0], 0, MOST_SHARE**2)))


def _room(shaft: Shaft, *, share: bool) -> tuple[Array, Array]:
    """Give how far down and up each parameter of the shape may go, (n,) each."""
    free = np.full(len(shaft.axis) + len(shaft.width), np.inf)
    low, high = [*(shaft.variance - LEAST_VARIANCE_PX2)], [np.inf, np.inf]
    if share:
        low.append(shaft.disc_share**2)
        high.append(MOST_SHARE**2 - shaft.disc_share**2)
    return np.concatenate([free, low]), np.concatenate([free, high])
