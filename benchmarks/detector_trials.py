"""Methods tried on a condition: every answer beside its truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from detector_methods import Answer, Claim, Method
from detector_shots import Shots

from simtip import SceneSpec
from simtip.geometry import Array
from simtip.score import pixel_error, point_error
from simtip.truth import SceneTruth, ViewTruth, scene_truth

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True)
class Look:
    """What a method said of one image.

    Attributes
    ----------
    pose, side
        Which of the condition's scenes it was, and which view: fresh noise alone tells equal ones
        apart.
    in_view
        Whether the true tip lies in the image.
    status
        Of the observation.
    along_px, across_px
        Error against the apex; None without a tip.
    width_px
        The needle's width at the tip.
    claimed_px2
        Claimed variance along and across; None if none is claimed.
    """

    pose: int
    side: Side
    in_view: bool
    status: str
    along_px: float | None
    across_px: float | None
    width_px: float
    claimed_px2: tuple[float, float] | None


@dataclass(frozen=True)
class Place:
    """What a method said of the tip in space.

    Attributes
    ----------
    error_mm
        Along the needle's axis, and along two directions square to it.
    claimed_mm2
        Claimed variance along the axis, and the sum of both square to it; None if none is claimed.
    """

    error_mm: tuple[float, float, float]
    claimed_mm2: tuple[float, float] | None

    @property
    def norm_mm(self) -> float:
        """Length of the error, mm."""
        return float(np.linalg.norm(self.error_mm))


@dataclass(frozen=True)
class Try:
    """One pair: both looks, the place in space (None without one) and the time taken.

    `of_both`: the looks are that place projected, and say nothing of their own.
    """

    looks: tuple[Look, Look]
    place: Place | None
    time_s: float
    of_both: bool = False


def tries(shots: Shots, method: Method) -> Iterator[Try]:
    """Let a method measure every pair of a condition.

    Raises
    ------
    NotForThisError
        It is not for such a needle.
    """
    for pose, scene in enumerate(shots.scenes):
        measure, truth = method(scene), scene_truth(scene)
        for exposure in range(shots.condition.exposures):
            yield _judged(pose, scene, truth, measure(shots.images(pose, exposure)))


def _judged(pose: int, scene: SceneSpec, truth: SceneTruth, answer: Answer) -> Try:
    looks = []
    for side, claim, camera in zip(
        SIDES, answer.views, (truth.rig.left, truth.rig.right), strict=True
    ):
        view: ViewTruth = getattr(truth, side)
        width_px = camera.K[0, 0] * scene.needle.diameter_mm / scene.needle.tip_mm[2]
        in_view = bool(camera.contains(view.tip_px))
        looks.append(_look(pose, side, claim, view, float(width_px), in_view=in_view))
    place = _place(answer, truth)
    return Try((looks[0], looks[1]), place, answer.time_s, answer.of_both)


def _look(
    pose: int, side: Side, claim: Claim, view: ViewTruth, width_px: float, *, in_view: bool
) -> Look:
    error = pixel_error(claim.tip_px, view.tip_px, view.axis_px)
    claimed = None
    if claim.covariance_px is not None:
        along = view.axis_px
        frame = np.array([along, [-along[1], along[0]]])
        variances = np.diag(frame @ claim.covariance_px @ frame.T)
        claimed = (float(variances[0]), float(variances[1]))
    along_px, across_px = (None, None) if error is None else (error.along_px, error.across_px)
    return Look(pose, side, in_view, claim.status, along_px, across_px, width_px, claimed)


def _place(answer: Answer, truth: SceneTruth) -> Place | None:
    error = point_error(answer.tip_mm, truth.tip_mm)
    if error is None:
        return None
    frame = _frame(truth.axis)
    along, one, other = frame @ (error.x_mm, error.y_mm, error.z_mm)
    claimed = None
    if answer.covariance_mm2 is not None:
        variances = np.diag(frame @ answer.covariance_mm2 @ frame.T)
        claimed = (float(variances[0]), float(variances[1:].sum()))
    return Place((float(along), float(one), float(other)), claimed)


def _frame(axis: Array) -> Array:
    """Give rows: the axis, and two directions square to it and to each other."""
    aside = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    aside /= np.linalg.norm(aside)
    return np.array([axis, aside, np.cross(axis, aside)])
