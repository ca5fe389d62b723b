"""Which corners and views do not fit the others, by rules that are stated here.

**Corners.** In a fit that wrong corners hardly pull (Huber), a corner is outlying if its residual
is longer than 6 standard deviations, taken from the median residual of its own image or of all,
whichever is larger, and longer than 0.02 px. Of normal noise, one corner in 7e7 is. Outlying
corners are left out and listed; if they are more than a tenth of what a camera saw in a view, it
is the view that is wrong, and it goes as a whole.

**Views.** The scatter of each view is judged against a calibration without it: the shared unknowns
are moved to what the other views make of them (to first order, from the view's part of the normal
equations), the board's pose is fitted anew, and what is left is divided by what equal noise would
leave. A view is outlying if its scatter is above 0.02 px, above twice the median of all views, and
above the median by 6 times their robust spread (1.4826 MAD). The worst goes first; then all is
fitted again.

**Pairs.** A view can fit passably and yet show a board that moved between the exposures. How much
worse one board explains what both cameras saw than a board for each would is a sum of squares, over
the six unknowns of a pose. A pair is outlying if its root mean square is above what a shift of all
corners by 0.02 px makes, above four times the median of all pairs, and above the median by 6 times
their robust spread.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.calibrate.bundle import Fit, huber_weights, spread
from simtip.calibrate.corners import Corners
from simtip.calibrate.normal_equations import Blocks, blocks, inverse, reduced
from simtip.calibrate.problem import POSE, Problem, Rows, linearised
from simtip.geometry import Array

SIGMAS = 6.0
"""Beyond this many robust standard deviations a corner, or a view's scatter, is outlying."""

FLOOR_PX = 0.02
"""What is smaller is never outlying: corners are not found better, and rounding is not noise."""

VIEW_MEDIANS = 2.0
"""An outlying view scatters by more than this many times the median view."""

PAIR_MEDIANS = 4.0
"""Left and right of an outlying pair disagree more than this many times as much as the median."""

CORNER_SHARE = 0.1
"""If more of a camera's corners in a view are outlying, the view is."""

VIEW_SHARE = 0.3
"""No more than this share of the views is ever left out for not fitting the others."""

MIN_VIEWS = 5
"""With fewer views, none can be told from the others."""

MAD_TO_SIGMA = 1.4826


@dataclass(frozen=True, eq=False)
class OutlyingCorners:
    """Corners that do not fit.

    Attributes
    ----------
    left, right
        (n,) whether each corner is outlying.
    views
        The views of which more than a tenth are, and what share of them, by the worse camera.
    """

    left: NDArray[np.bool_]
    right: NDArray[np.bool_]
    views: dict[int, float]


def outlying_corners(problem: Problem, fit: Fit) -> OutlyingCorners:
    """Apply the rule for corners to a robust fit."""
    everywhere = spread(fit.left, fit.right)
    left = _outlying(problem.left, fit.left, problem.views, everywhere)
    right = _outlying(problem.right, fit.right, problem.views, everywhere)
    shares: dict[int, float] = {}
    for corners, outlying in ((problem.left, left), (problem.right, right)):
        for i, part in enumerate(corners.slices(problem.views)):
            share = float(outlying[part].mean()) if outlying[part].any() else 0.0
            if share > CORNER_SHARE:
                shares[i] = max(share, shares.get(i, 0.0))
    return OutlyingCorners(left, right, shares)


def _outlying(
    corners: Corners, residual: Array, views: int, everywhere: float
) -> NDArray[np.bool_]:
    outlying = np.zeros(len(corners), dtype=np.bool_)
    for part in corners.slices(views):
        scale = max(everywhere, spread(residual[part]))
        limit = max(SIGMAS * scale, FLOOR_PX)
        outlying[part] = np.linalg.norm(residual[part], axis=1) > limit
    return outlying


@dataclass(frozen=True, eq=False)
class Scatter:
    """How much each view scatters in the eyes of the others.

    Attributes
    ----------
    px
        (views,) standard deviation of a coordinate, px.
    limit_px
        Beyond it a view is outlying.
    disagreement
        (views,) how much left and right disagree about the board, in parts of their limit; 0 for
        views seen by one camera.
    """

    px: Array
    limit_px: float
    disagreement: Array

    @property
    def worst(self) -> int | None:
        """The view furthest beyond a limit, if any is."""
        beyond = np.maximum(self.px / self.limit_px, self.disagreement)
        i = int(np.argmax(beyond))
        return i if beyond[i] > 1 else None


def scatter_of_views(problem: Problem, fit: Fit) -> Scatter:
    """Apply the rule for views to a robust fit."""
    rows = linearised(problem, fit.at)
    scale = spread(fit.left, fit.right)
    weights = huber_weights(fit.left, scale), huber_weights(fit.right, scale)
    px = _without_itself(problem, blocks(problem, rows), blocks(problem, rows, weights))
    if problem.views < MIN_VIEWS:
        return Scatter(px, np.inf, np.zeros(problem.views))
    limit_px = max(FLOOR_PX, _limit(px, VIEW_MEDIANS))
    return Scatter(px, limit_px, _disagreement(problem, rows))


def _limit(values: Array, medians: float) -> float:
    """Give the limit that the values (n,) themselves set."""
    median = float(np.median(values))
    robust = MAD_TO_SIGMA * float(np.median(np.abs(values - median)))
    return max(medians * median, median + SIGMAS * robust)


def _disagreement(problem: Problem, rows: tuple[Rows, Rows]) -> Array:
    """Compare one board for both cameras with a board for each, to first order."""
    sides = problem.left.slices(problem.views), problem.right.slices(problem.views)
    root, floor = np.zeros(problem.views), np.zeros(problem.views)
    pairs = []
    for i, parts in enumerate(zip(*sides, strict=True)):
        if any(part.start == part.stop for part in parts):
            continue
        pairs.append(i)
        V, b = zip(
            *(_pose_block(side, part) for side, part in zip(rows, parts, strict=True)), strict=True
        )
        apart = sum(_explained(V_c, b_c) for V_c, b_c in zip(V, b, strict=True))
        root[i] = np.sqrt(max(apart - _explained(V[0] + V[1], b[0] + b[1]), 0.0) / POSE)
        # boards d px apart, each camera half of it off: n (d / 2)^2, n corners in both
        corners = sum(part.stop - part.start for part in parts)
        floor[i] = FLOOR_PX / 2 * np.sqrt(corners / POSE)
    if len(pairs) < MIN_VIEWS:
        return np.zeros(problem.views)
    limit = _limit(root[pairs], PAIR_MEDIANS)
    root[pairs] /= np.maximum(limit, floor[pairs])
    return root


def _pose_block(rows: Rows, part: slice) -> tuple[Array, Array]:
    A = rows.board[part].reshape(-1, POSE)
    return A.T @ A, A.T @ rows.residual[part].ravel()


def _explained(V: Array, b: Array) -> float:
    """Give the fall of the sum of squares by the best step of a pose."""
    return float(b @ inverse(V) @ b)


def _without_itself(problem: Problem, plain: Blocks, weighted: Blocks) -> Array:
    """Give each view's scatter after a step to what the other views alone make of the shared."""
    own, pulling = reduced(plain), reduced(weighted)
    S, b = pulling.S.sum(axis=0), pulling.b.sum(axis=0)
    coordinates = 2 * (
        np.bincount(problem.left.view, minlength=problem.views)
        + np.bincount(problem.right.view, minlength=problem.views)
    )
    px = np.zeros(problem.views)
    for i in range(problem.views):
        unit = 1 / np.sqrt(np.diagonal(S))
        others = (S - pulling.S[i]) * unit[:, None] * unit
        S_i, b_i = own.S[i] * unit[:, None] * unit, own.b[i] * unit
        # what the others leave open stays where it is
        inverse = np.linalg.pinv(others, rcond=1e-10, hermitian=True)
        step = inverse @ ((b - pulling.b[i]) * unit)
        cost = own.cost[i] - 2 * step @ b_i + step @ S_i @ step
        expected = coordinates[i] - POSE + np.trace(S_i @ inverse)
        px[i] = np.sqrt(max(float(cost), 0.0) / expected)
    return px
