"""Whether the two cameras saw the same board: the reason why a pair does not fit."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from simtip.calibrate.corners import Corners
from simtip.calibrate.problem import Problem, Unknowns, residuals
from simtip.geometry import Array


@dataclass(frozen=True)
class Alone:
    """A view's board as each camera alone sees it.

    Attributes
    ----------
    px
        Scatter of the worse camera (root mean square of u and v), px, with the board where that
        camera wants it.
    apart_mm
        Between the two places of the seen points' middle; 0 if one camera saw the view.
    """

    px: float
    apart_mm: float


def seen_alone(problem: Problem, at: Unknowns, view: int) -> Alone:
    """Fit the board of one view to each camera for itself, with the cameras as they are."""
    left, right = (c.kept(c.view == view) for c in (problem.left, problem.right))
    R_l, t_l, px_l = _placed(left, at.left, at.turns[view], at.shifts[view])
    R_r, t_r, px_r = _placed(
        right, at.right, at.R.T @ at.turns[view], (at.shifts[view] - at.T) @ at.R
    )
    apart = 0.0
    if len(left) and len(right):
        middle = left.points_mm.mean(axis=0)
        apart = float(np.linalg.norm(R_l @ middle + t_l - at.R @ (R_r @ middle + t_r) - at.T))
    return Alone(max(px_l, px_r), apart)


def _placed(corners: Corners, numbers: Array, R: Array, t: Array) -> tuple[Array, Array, float]:
    if not len(corners):
        return R, t, 0.0
    fx, fy, cx, cy = numbers[:4]
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    _, turn, shift = cv2.solvePnP(
        corners.points_mm,
        corners.pixels,
        K,
        numbers[4:],
        Rotation.from_matrix(R).as_rotvec().reshape(3, 1),
        t.reshape(3, 1).copy(),
        useExtrinsicGuess=True,
        flags=cv2.SOLVEPNP_ITERATIVE,
    )
    modelled, _ = cv2.projectPoints(corners.points_mm, turn, shift, K, numbers[4:])
    residual = corners.pixels - np.asarray(modelled, dtype=np.float64).reshape(-1, 2)
    scatter = float(np.sqrt((residual**2).mean()))
    return Rotation.from_rotvec(np.ravel(turn)).as_matrix(), np.ravel(shift), scatter


def why_outlying(
    problem: Problem, at: Unknowns, view: int, limit_px: float, wrong_share: float
) -> str:
    """Say in one sentence why a view does not fit the others.

    Parameters
    ----------
    problem, at
        All views, and what they were fitted with.
    view
        Which one.
    limit_px
        The scatter that the other views allow.
    wrong_share
        Share of a camera's corners in the view that are outlying one by one.
    """
    alone = seen_alone(problem, at, view)
    left, right = residuals(problem, at)
    own = [left[problem.left.view == view], right[problem.right.view == view]]
    together = float(np.sqrt((np.concatenate(own) ** 2).mean()))
    # the view itself has pulled the cameras, so that alone it need not fit within the limit
    if alone.apart_mm > 0 and alone.px <= max(limit_px, together / 2):
        return (
            f"left and right see the board in places {alone.apart_mm:.2g} mm apart: it moved "
            "between the two exposures, or is not the same view"
        )
    if wrong_share > 0:
        return f"{wrong_share:.0%} of a camera's corners in it do not fit"
    return f"its corners scatter by {alone.px:.2g} px; the other views allow {limit_px:.2g} px"
