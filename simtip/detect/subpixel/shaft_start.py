"""Where the shaft's fit begins, and between which edges it has to lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simtip.detect.observation import TipStatus
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_fit import fit, fits, glance, halved, is_sharp
from simtip.detect.subpixel.shaft_pixels import BLOCK_ROWS, edges_px

START_BLURS = (
    *((variance, 0.0) for variance in (0.03, 0.6)),
    *((variance, 0.7) for variance in (0.25, 0.7, 1.5, 3.0)),
)
"""Variance, px^2, and the disc's share: from each the shaft's fit begins, and the best is kept."""

UNEVEN_MISFIT, EVENER = 3.0, 0.4
"""A shaft that fits worse is tried anew with half its rows; they are taken if at most such a part
of the misfit is left: of what fits badly everywhere, more rows tell more."""

HOPEFUL = 1.4
"""So many times that is left at most, after the first steps, of what is worth all of them."""

SHORTEST_HALVED = 8 * BLOCK_ROWS

EDGE_SHORT_PX = 0.2
"""By which a half width by the edges' middles usually falls short: rims are brighter than what
lies within them."""

WIDTH_SLACK_PX = 0.35

EDGE_PARTS, EDGE_VARIANCE_PX2, EDGE_PASSES = 4, 0.6, 3
"""Parts of the shaft whose mean edges are looked for, and the blur that is allowed for there; it is
looked anew around a shaft that was moved by more than a pixel."""


def even_shaft(
    image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft, *, any_width: bool = False
) -> Shaft:
    """Fit the shaft; where a highlight comes and goes along it, only the part next to the tip.

    With `any_width` one that is far wider or narrower than its traced edges counts, too.
    """
    rows, start, seen = _even_at_a_glance(image, rows, begun)
    shaft = _fitted(image, rows, start, seen, any_width=any_width)
    while shaft.misfit > UNEVEN_MISFIT and len(rows) >= SHORTEST_HALVED:
        rows = rows[len(rows) // 2 :]
        if not _promising(image, rows, shaft):
            break
        shorter = _fitted(image, rows, _start(image, rows, begun), any_width=any_width)
        if shorter.misfit > EVENER * shaft.misfit:
            break
        shaft = shorter
    return shaft


def _promising(image: NDArray[np.float32], rows: NDArray[np.intp], shaft: Shaft) -> bool:
    """Say whether a shaft might fit some of its rows so much better that they are taken."""
    try:
        part = halved(image, rows, shaft)
    except np.linalg.LinAlgError:
        return True
    return part.misfit < HOPEFUL * EVENER * shaft.misfit


def _even_at_a_glance(
    image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft
) -> tuple[NDArray[np.intp], Shaft, Shaft | None]:
    """Give the rows without those that are plainly uneven, a start, and what a look from it shows.

    What is sharp and fits badly is no matter of the blur: others need not be tried to see that.
    """
    start = _start(image, rows, begun)
    try:
        seen = glance(image, rows, start)
        while is_sharp(seen) and not fits(seen) and len(rows) >= SHORTEST_HALVED:
            shorter = rows[len(rows) // 2 :]
            other = _start(image, shorter, begun)
            part = glance(image, shorter, other)
            if not is_sharp(part) or part.misfit > min(UNEVEN_MISFIT, EVENER * seen.misfit):
                break
            rows, start, seen = shorter, other, part
    except np.linalg.LinAlgError:
        return rows, start, None
    return rows, start, seen


def _start(image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft) -> Shaft:
    """Give the sharpest start, between the mean edges; short shafts are straight, of even width."""
    origin, scale = float(rows[-1]), float(len(rows))
    short = len(rows) < 4 * BLOCK_ROWS
    slope = float(begun.slope(np.array(origin)))
    axis = np.array([float(begun.axis_u(np.array(origin))), slope * scale, 0.0, 0.0])
    width = np.array([begun.width[0], 0.0, 0.0])
    moved = replace(
        begun,
        origin=origin,
        scale=scale,
        axis=axis[:2] if short else axis,
        width=width[:2] if short else width,
    )
    moved = replace(moved, variance=np.full(2, EDGE_VARIANCE_PX2))
    for _ in range(EDGE_PASSES):
        before, moved = moved, _between_edges(image, rows, moved)
        if abs(moved.axis[0] - before.axis[0]) + abs(moved.width[0] - before.width[0]) < 1:
            break
    return _blurred(moved, *START_BLURS[0])


def _fitted(
    image: NDArray[np.float32],
    rows: NDArray[np.intp],
    start: Shaft,
    seen: Shaft | None = None,
    *,
    any_width: bool,
) -> Shaft:
    """Fit the shaft from several blurs; from the sharpest as far as it was seen already."""
    half = float(start.width[0])
    starts = [start, *(_blurred(start, *blur) for blur in START_BLURS[1:])]

    def likely(one: Shaft) -> bool:
        # In a blurred picture a wider, sharper needle with bright rims looks nearly the same.
        return bool(abs(one.width[0] - half) < _slack_px(one))

    try:
        return fit(image, rows, starts, likely, seen, any_width=any_width)
    except np.linalg.LinAlgError as error:
        raise NoNeedleError(
            TipStatus.NOT_FOUND, "the shaft's brightness cannot be fitted"
        ) from error


def _blurred(shaft: Shaft, variance: float, share: float) -> Shaft:
    return replace(shaft, variance=np.full(2, variance), disc_share=share)


def _between_edges(image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft) -> Shaft:
    """Move a shaft between its mean edges, and taper it as those of its parts do."""
    parts = np.array_split(rows, EDGE_PARTS if len(begun.width) > 1 else 1)
    edges = np.array([edges_px(image, part, begun) for part in parts])
    t = begun.t(np.array([part.mean() for part in parts]))
    half = edges.mean(axis=1) + EDGE_SHORT_PX
    width = begun.width.copy()
    width[:2] = np.polyfit(t, half, 1)[::-1] if len(parts) > 1 else half
    axis = begun.axis.copy()
    incline = float(np.hypot(1, begun.slope(np.array(begun.origin))))
    axis[0] += float(np.mean(edges[:, 1] - edges[:, 0])) / 2 * incline
    return replace(begun, axis=axis, width=width)


def _slack_px(shaft: Shaft) -> float:
    """Give how far a half width may be from what the edges' traces say."""
    return WIDTH_SLACK_PX + 0.15 * float(np.sqrt(shaft.variance.max()))
