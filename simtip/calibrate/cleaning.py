"""The joint adjustment, again and again, until what is left fits."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from simtip.calibrate.bundle import Fit, adjust
from simtip.calibrate.calibration import RejectedCorner
from simtip.calibrate.lens_model import LensModel
from simtip.calibrate.moved import why_outlying
from simtip.calibrate.outliers import (
    VIEW_SHARE,
    OutlyingCorners,
    outlying_corners,
    scatter_of_views,
)
from simtip.calibrate.problem import Problem, Unknowns
from simtip.calibrate.selection import Selection
from simtip.errors import InputError

Kept: TypeAlias = tuple[NDArray[np.bool_], NDArray[np.bool_]]


def cleaned(
    selection: Selection, start: Unknowns, model: LensModel, allowed: int
) -> tuple[Problem, Fit]:
    """Leave out what does not fit, worst first, and adjust the rest by plain least squares.

    Parameters
    ----------
    selection
        Views and corners that do not fit are taken out of it.
    start
        Where to begin.
    model
        Of the distortion.
    allowed
        How many views may be left out.

    Raises
    ------
    InputError
        The views do not determine the rig, or too few are left.
    """
    at = start
    while True:
        problem = selection.problem(model)
        fit = _adjusted(problem, at, robust=True)
        outlying = outlying_corners(problem, fit)
        view, limit_px = _outlying_view(problem, fit, outlying)
        if view is None or not allowed:
            break
        reason = why_outlying(problem, fit.at, view, limit_px, outlying.views.get(view, 0.0))
        selection.reject(selection.views[view].name, reason)
        allowed -= 1
        left = [i for i in range(problem.views) if i != view]
        at = replace(fit.at, turns=fit.at.turns[left], shifts=fit.at.shifts[left])
    if view is not None:
        selection.warnings.append(
            f"view {selection.views[view].name}, and maybe others, does not fit; it was kept, for "
            f"no more than {VIEW_SHARE:.0%} of the views are left out"
        )
    selection.require_pairs("consistently by both cameras")
    clean, kept = _without(problem, outlying)
    _list_corners(selection, problem, fit, kept)
    return clean, _adjusted(clean, fit.at, robust=False)


def _adjusted(problem: Problem, at: Unknowns, *, robust: bool) -> Fit:
    try:
        return adjust(problem, at, robust=robust)
    except np.linalg.LinAlgError:
        raise InputError(
            "the views do not determine the rig: the least-squares problem is singular",
            field="views",
            remedy="take more views that both cameras see",
        ) from None


def _outlying_view(
    problem: Problem, fit: Fit, outlying: OutlyingCorners
) -> tuple[int | None, float]:
    """Name the view that fits worst, if one does not fit, and the limit set by the others, px."""
    clean, (left, right) = _without(problem, outlying)
    scatter = scatter_of_views(clean, replace(fit, left=fit.left[left], right=fit.right[right]))
    if outlying.views:
        return max(outlying.views, key=lambda i: outlying.views[i]), scatter.limit_px
    return scatter.worst, scatter.limit_px


def _without(problem: Problem, outlying: OutlyingCorners) -> tuple[Problem, Kept]:
    """Take outlying corners out of views that have few of them."""
    whole = list(outlying.views)
    left = ~outlying.left | np.isin(problem.left.view, whole)
    right = ~outlying.right | np.isin(problem.right.view, whole)
    clean = replace(problem, left=problem.left.kept(left), right=problem.right.kept(right))
    return clean, (left, right)


def _list_corners(selection: Selection, problem: Problem, fit: Fit, kept: Kept) -> None:
    sides = (
        ("left", problem.left, fit.left, kept[0]),
        ("right", problem.right, fit.right, kept[1]),
    )
    for camera, corners, residual, stays in sides:
        for i in np.flatnonzero(~stays):
            selection.corners.append(
                RejectedCorner(
                    view=selection.views[corners.view[i]].name,
                    camera=camera,
                    id=int(corners.ids[i]),
                    residual_px=float(np.linalg.norm(residual[i])),
                )
            )
