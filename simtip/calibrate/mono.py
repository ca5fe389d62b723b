"""One camera alone: Zhang's method as OpenCV has it, then least squares to the end.

OpenCV starts from homographies and knows two radial coefficients here; the adjustment adds the
rest of the model and weighs wrong corners down.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from simtip.calibrate.bundle import Fit, adjust, spread
from simtip.calibrate.corners import Corners
from simtip.calibrate.lens_model import LENGTH, LensModel, camera_of
from simtip.calibrate.problem import Problem, Unknowns
from simtip.camera import folds
from simtip.errors import InputError
from simtip.geometry import Array

UNDETERMINED = (
    "move and tilt the board between the views: about 30 degrees, towards different sides"
)

KEPT_SIGMAS = 6.0
"""Models are compared on the corners within this many robust standard deviations."""

NEGLIGIBLE_PX = 1e-3
"""Residuals below this say nothing about models: corners are never as good."""


def problem_of(corners: Corners, views: int, model: LensModel) -> Problem:
    """State the problem of one camera; each of the views is in the table."""
    none = corners.kept(np.zeros(len(corners), dtype=np.bool_))
    return Problem(corners, none, views, model)


def first_guess(corners: Corners, views: int, size: tuple[int, int], camera: str) -> Unknowns:
    """Start one camera by Zhang's method.

    Parameters
    ----------
    corners
        Of the camera, with each of the views in it.
    views
        How many there are.
    size
        (width, height) of its images, px.
    camera
        ``left`` or ``right``, for messages.

    Raises
    ------
    InputError
        The views do not determine the camera.
    """
    parts = corners.slices(views)
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    try:
        with _one_thread():
            _, K, D, rvecs, tvecs = cv2.calibrateCamera(
                [corners.points_mm[part].astype(np.float32) for part in parts],
                [corners.pixels[part].astype(np.float32) for part in parts],
                size,
                None,
                None,
                flags=flags,
            )
    except cv2.error:
        raise undetermined(camera, "Zhang's method found no solution") from None
    numbers = np.zeros(LENGTH)
    numbers[:4] = K[0, 0], K[1, 1], K[0, 2], K[1, 2]
    numbers[4:6] = np.ravel(D)[:2]
    shifts = np.reshape(np.asarray(tvecs, dtype=np.float64), (views, 3))
    vectors = np.reshape(np.asarray(rvecs, dtype=np.float64), (views, 3))
    if not (np.isfinite(numbers).all() and np.isfinite(vectors).all() and (numbers[:2] > 0).all()):
        raise undetermined(camera, "Zhang's method found no solution")
    turns = Rotation.from_rotvec(vectors).as_matrix()
    return Unknowns(numbers, np.zeros(LENGTH), np.eye(3), np.zeros(3), turns, shifts)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Keep OpenCV to one thread: several add up in any order, and the last bits are then chance."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def calibrate_one(
    corners: Corners, views: int, size: tuple[int, int], model: LensModel, camera: str
) -> Fit:
    """Calibrate one camera robustly; parameters as in `first_guess`.

    Raises
    ------
    InputError
        The views do not determine the camera.
    """
    guess = first_guess(corners, views, size, camera)
    return _fitted(problem_of(corners, views, model), guess, camera, robust=True)


def _fitted(problem: Problem, guess: Unknowns, camera: str, *, robust: bool) -> Fit:
    try:
        return adjust(problem, _restricted(guess, problem.model), robust=robust)
    except np.linalg.LinAlgError:
        raise undetermined(camera, "the least-squares problem is singular") from None


def _restricted(guess: Unknowns, model: LensModel) -> Unknowns:
    left = np.zeros(LENGTH)
    left[model.free] = guess.left[model.free]
    return replace(guess, left=left)


def undetermined(camera: str, why: str) -> InputError:
    """Make the error for views that leave a camera open."""
    return InputError(
        f"the views do not determine the {camera} camera: {why}",
        field="views",
        remedy=UNDETERMINED,
    )


def choose_model(
    tables: tuple[tuple[Corners, int], tuple[Corners, int]],
    sizes: tuple[tuple[int, int], tuple[int, int]],
) -> tuple[LensModel, dict[LensModel, float]]:
    """Choose the distortion model of both cameras by the Bayesian information criterion.

    ``BIC = n ln(RSS / n) + k ln n`` (Schwarz 1978), n coordinates, k unknowns of the camera, summed
    over the cameras, each calibrated alone; the least wins. Corners beyond six robust standard
    deviations of the best-fitting model are left out for all. A model that folds inside the image
    is not chosen. Corner errors that are not independent make it lean to the richer model.

    Parameters
    ----------
    tables, sizes
        Corners with the number of views, and the image size, px, of the left and the right camera.

    Returns
    -------
    model, criterion
        The choice, and the criterion of each model; infinite for one that folds.

    Raises
    ------
    InputError
        The views do not determine a camera.
    """
    total = dict.fromkeys(LensModel, 0.0)
    for camera, (corners, count), size in zip(("left", "right"), tables, sizes, strict=True):
        for model, value in _criteria(corners, count, size, camera).items():
            total[model] += value
    return min(LensModel, key=lambda model: total[model]), total


def _criteria(
    corners: Corners, views: int, size: tuple[int, int], camera: str
) -> dict[LensModel, float]:
    guess = first_guess(corners, views, size, camera)
    fits = {
        model: _fitted(problem_of(corners, views, model), guess, camera, robust=True)
        for model in LensModel
    }
    best = min(fits.values(), key=lambda fit: spread(fit.left))
    keep = _within(best.left)
    criteria = {}
    for model, fit in fits.items():
        problem = problem_of(corners.kept(keep), views, model)
        plain = _fitted(problem, fit.at, camera, robust=False)
        bad = folds(camera_of(plain.at.left, model, size))
        criteria[model] = np.inf if bad else _bic(plain.left, len(model.free))
    return criteria


def _within(residual: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    limit = KEPT_SIGMAS * max(spread(residual), NEGLIGIBLE_PX)
    kept: np.ndarray[tuple[int], np.dtype[np.bool_]] = np.linalg.norm(residual, axis=1) <= limit
    return kept


def _bic(residual: Array, unknowns: int) -> float:
    n = residual.size
    mean_square = max(float((residual**2).mean()), NEGLIGIBLE_PX**2)
    return n * float(np.log(mean_square)) + unknowns * float(np.log(n))
