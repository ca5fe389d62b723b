"""From what two cameras saw of a target to a calibrated rig."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from simtip.calibrate.bundle import Fit, spread
from simtip.calibrate.calibration import Calibration, Reprojection
from simtip.calibrate.checks import check_input, require_determined, require_order, require_tilts
from simtip.calibrate.cleaning import cleaned
from simtip.calibrate.corners import View
from simtip.calibrate.fundamental import EpipolarDistances, eight_point, epipolar_of, scaled
from simtip.calibrate.lens_model import LensModel, camera_of, lens_model
from simtip.calibrate.mono import calibrate_one, choose_model, problem_of
from simtip.calibrate.outliers import FLOOR_PX, VIEW_SHARE
from simtip.calibrate.pairing import brought_together
from simtip.calibrate.problem import Problem
from simtip.calibrate.selection import Selection, screened
from simtip.calibrate.uncertainty import deviations, uncertainty_of
from simtip.camera import StereoRig, folds
from simtip.geometry import Array, Pose

CAMERAS = "left", "right"

TOGETHER = 1.5
"""A joint fit this many times worse than each camera's own is warned of; 1.01 is usual."""

Size: TypeAlias = tuple[int, int]


def calibrate(
    views: Sequence[View],
    points_mm: Array,
    left_size: Size,
    right_size: Size,
    *,
    model: str = LensModel.OPENCV5,
    turnable: bool = True,
) -> Calibration:
    """Calibrate a stereo rig: each camera, then everything at once by least squares.

    All corners of both cameras enter one adjustment of both cameras, their relative pose and every
    board's pose, those of views seen by one camera only among them. What does not fit is left out
    by the rules of `simtip.calibrate.outliers` and listed.

    Parameters
    ----------
    views
        What the cameras saw.
    points_mm
        (n, 3) the target's points, z = 0, x right and y down on the printed side.
    left_size, right_size
        (width, height) of the images, px.
    model
        ``none``, ``radial2``, ``radtan``, ``opencv5``, ``rational``, or ``auto`` for the one with
        the least Bayesian information criterion.
    turnable
        Whether the finder may number the points of a symmetric target from another end, as it may
        on a chessboard or a circle grid, so that left and right can differ. Such views are then
        put right and listed; without it (ChArUco) they are rejected.

    Returns
    -------
    Calibration
        The rig, in the left camera's frame, and how good it is.

    Raises
    ------
    InputError
        There is nothing that can be calibrated: too few views, parallel boards, left and right
        swapped or not paired, mirrored images, points outside the image.
    """
    points = np.asarray(points_mm, dtype=np.float64)
    sizes = left_size, right_size
    check_input(views, points, sizes)
    selection = screened(views, points)
    entered = len(selection.views)
    for camera, size in zip(CAMERAS, sizes, strict=True):
        require_tilts(selection.seen_by(camera)[1], points, size, camera)
    chosen = lens_model(model)
    criterion: dict[LensModel, float] = {}
    if chosen is None:
        chosen, criterion = choose_model((selection.table("left"), selection.table("right")), sizes)
    alone = _alone(selection, sizes, chosen)
    start = brought_together(selection, alone, turnable=turnable)
    allowed = int(VIEW_SHARE * entered) - (entered - len(selection.views))
    problem, fit = cleaned(selection, start, chosen, max(allowed, 0))
    return _result(selection, problem, fit, sizes, alone, criterion)


def _alone(selection: Selection, sizes: tuple[Size, Size], model: LensModel) -> tuple[Fit, Fit]:
    fits = []
    for camera, size in zip(CAMERAS, sizes, strict=True):
        corners, count = selection.table(camera)
        fit = calibrate_one(corners, count, size, model, camera)
        require_determined(problem_of(corners, count, model), fit, size, camera)
        fits.append(fit)
    return fits[0], fits[1]


def _result(
    selection: Selection,
    problem: Problem,
    fit: Fit,
    sizes: tuple[Size, Size],
    alone: tuple[Fit, Fit],
    criterion: dict[LensModel, float],
) -> Calibration:
    at = fit.at
    left = camera_of(at.left, problem.model, sizes[0])
    right = camera_of(at.right, problem.model, sizes[1])
    rig = StereoRig(left, right, Pose(at.R, at.T))
    require_order(rig.T_lr.t)
    for name, camera in (("left", left), ("right", right)):
        if folds(camera):
            selection.warnings.append(
                f"the {name} camera's distortion folds inside the image: a simpler model is needed"
            )
    _warn_of_pairs(selection, alone, fit)
    uncertainty = uncertainty_of(problem, fit)
    pairs = _pairs(problem)
    raw = epipolar_of(*pairs, eight_point(*pairs))
    return Calibration(
        rig=rig,
        model=problem.model,
        views_used=tuple(view.name for view in selection.views),
        views_rejected=tuple(selection.rejected),
        corners_rejected=tuple(selection.corners),
        views_turned=tuple(selection.turned),
        board_poses=tuple(Pose(R, t) for R, t in zip(at.turns, at.shifts, strict=True)),
        left=Reprojection(problem.left, fit.left),
        right=Reprojection(problem.right, fit.right),
        rms_alone_px=(_rms(alone[0].left), _rms(alone[1].left)),
        uncertainty=uncertainty,
        std=deviations(uncertainty, problem, fit),
        epipolar_raw=raw,
        **_undistorted(rig, pairs),
        criterion=criterion,
        warnings=tuple(selection.warnings),
    )


def _warn_of_pairs(selection: Selection, alone: tuple[Fit, Fit], fit: Fit) -> None:
    """Warn if the cameras fit together much worse than each alone, whichever views are to blame."""
    apart, together = spread(alone[0].left, alone[1].left), spread(fit.left, fit.right)
    if together > max(FLOOR_PX, TOGETHER * apart):
        selection.warnings.append(
            f"the cameras fit the views together to {together:.2g} px, each alone to {apart:.2g} "
            "px: in many views the board moved between the exposures, or the cameras did"
        )


def _rms(residual: Array) -> float:
    return float(np.sqrt((residual**2).sum(axis=1).mean()))


def _undistorted(rig: StereoRig, pairs: tuple[Array, Array]) -> dict[str, EpipolarDistances]:
    left, right = rig.left.undistort(pairs[0]), rig.right.undistort(pairs[1])
    # a lens model that folds has no ray for some pixels
    there = np.isfinite(left).all(axis=1) & np.isfinite(right).all(axis=1)
    left, right = left[there], right[there]
    return {
        "epipolar": epipolar_of(left, right, eight_point(left, right)),
        "epipolar_rig": epipolar_of(left, right, scaled(rig.fundamental())),
    }


def _pairs(problem: Problem) -> tuple[Array, Array]:
    """Give the pixels (n, 2) of every point that both cameras saw in the same view."""
    points = 1 + max(int(problem.left.ids.max()), int(problem.right.ids.max()))
    _, left, right = np.intersect1d(
        problem.left.view * points + problem.left.ids,
        problem.right.view * points + problem.right.ids,
        return_indices=True,
    )
    return problem.left.pixels[left], problem.right.pixels[right]
