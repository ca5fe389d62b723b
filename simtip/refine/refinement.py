"""The needle's place from both pictures at once, its shape known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np

from simtip.camera import StereoRig
from simtip.detect.protocol import Image
from simtip.detect.subpixel.analysis import Analysis, analyse
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.parameters import SubpixelParameters
from simtip.geometry import Array, Pose
from simtip.refine.outline import Eye
from simtip.refine.place import first_place, roll_deg, rolled
from simtip.refine.solid import Solid
from simtip.refine.solve import Problem, Solution, State
from simtip.refine.view import View

ROLLS = 24
"""Rolls that are tried to begin with."""

BEST_ROLLS = 2
"""Of them, that are followed for `FIRST_STEPS`."""

FIRST_STEPS = 3

NEAR_STEPS = 4

GREATEST_MISFIT = 25.0
"""Mean squared residual, over noise and ripples of lossy storage, beyond which the needle is of
another shape or in another place."""


class RefineStatus(StrEnum):
    """Machine-readable outcome of a refinement."""

    OK = "ok"
    LEFT_NOT_FOUND = "left_not_found"
    RIGHT_NOT_FOUND = "right_not_found"
    NO_START = "no_start"
    NOT_SETTLED = "not_settled"
    MISFIT = "misfit"


@dataclass(frozen=True, eq=False)
class Refinement:
    """The needle's place, or the reason why there is none.

    Attributes
    ----------
    status
        ``ok``, or the code of the reason.
    reason
        One sentence with the numbers; empty when there is a place.
    tip_mm
        (3,) the apex, rig frame, mm.
    covariance_mm2
        (3, 3) of it, mm^2.
    axis
        (3,) unit direction from the tip to the hub, rig frame.
    roll_deg
        As scenes count it; None for a tip that is the same all around.
    tips_px
        (2, 2) u, v of the apex in the left and the right picture.
    misfit
        (2,) mean squared residual over the noise, left and right: 1 if the model is right, more
        where lossy storage has left ripples.
    """

    status: RefineStatus
    reason: str = ""
    tip_mm: Array | None = None
    covariance_mm2: Array | None = None
    axis: Array | None = None
    roll_deg: float | None = None
    tips_px: Array | None = None
    misfit: Array | None = None

    @property
    def ok(self) -> bool:
        """Whether there is a place."""
        return self.status is RefineStatus.OK

    def to_dict(self) -> dict[str, Any]:
        """Give plain lists and numbers: the keys under ``refined`` of ``measure --json``."""
        names = ("left", "right")
        tips = None if self.tips_px is None else self.tips_px.tolist()
        misfit = None if self.misfit is None else self.misfit.tolist()
        return {
            "status": str(self.status),
            "reason": self.reason,
            "tip_mm": None if self.tip_mm is None else self.tip_mm.tolist(),
            "covariance_mm2": None if self.covariance_mm2 is None else self.covariance_mm2.tolist(),
            "axis": None if self.axis is None else self.axis.tolist(),
            "roll_deg": self.roll_deg,
            "tip_px": tips and dict(zip(names, tips, strict=True)),
            "misfit": misfit and dict(zip(names, misfit, strict=True)),
        }


Refiner: TypeAlias = Callable[[Image, Image, StereoRig], Refinement]
"""Takes the left and the right picture and the rig that took them."""


def silhouette(solid: Solid, full_scale: int | None = None) -> Refiner:
    """Give `refine` for one needle, as `simtip.measure.measure_pair` takes it."""

    def refiner(left: Image, right: Image, rig: StereoRig) -> Refinement:
        return refine(left, right, rig, solid, full_scale=full_scale)

    return refiner


def refine(
    left: Image,
    right: Image,
    rig: StereoRig,
    solid: Solid,
    *,
    start: tuple[Analysis, Analysis] | None = None,
    full_scale: int | None = None,
) -> Refinement:
    """Find the place of a known needle from a pair of pictures.

    Parameters
    ----------
    left, right
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16.
    rig
        The calibrated cameras.
    solid
        The needle's shape.
    start
        What `subpixel` found in both pictures; by default it looks.
    full_scale
        White of a 16-bit picture; None is 65535.

    Returns
    -------
    Refinement
        A needle that is not found, or does not fit, is a value with its reason.

    Raises
    ------
    InputError
        An array is no image of a supported kind.
    """
    found = analyses(left, right, rig, full_scale) if start is None else start
    if isinstance(found, Refinement):
        return found
    T_wn = first_place(*found, rig)
    if T_wn is None:
        return Refinement(
            RefineStatus.NO_START, "the lines of sight to both tips meet nowhere before the rig"
        )
    eyes = (
        Eye(rig.left, Pose.identity(), found[0].frame),
        Eye(rig.right, rig.T_lr.inverse(), found[1].frame),
    )

    def problem(T_wn: Pose) -> Problem:
        one, other = (
            View.of(image, seen, eye, solid, T_wn, full_scale)
            for image, seen, eye in zip((left, right), found, eyes, strict=True)
        )
        return Problem(solid, (one, other))

    first = problem(T_wn)
    near = first.settle(_first_state(first, T_wn), NEAR_STEPS).state
    # Known better now: where the needle ends, and so which pixels are about it; and the noise,
    # which the shaft's fit takes for too much where edges run askew.
    again = problem(near.T_wn).with_noise_left(near.fits)
    ripples = np.array([view.ripples for view in again.views])
    return _judged(again.settle(again.state(near.T_wn, near.blur)), solid, rig, ripples)


def analyses(
    left: Image, right: Image, rig: StereoRig, full_scale: int | None
) -> tuple[Analysis, Analysis] | Refinement:
    """Look for the needle in both pictures, as `refine` does; or tell why it is not found."""
    found = []
    for image, camera, status in (
        (left, rig.left, RefineStatus.LEFT_NOT_FOUND),
        (right, rig.right, RefineStatus.RIGHT_NOT_FOUND),
    ):
        parameters = SubpixelParameters(
            full_scale=full_scale,
            focal_px=float(camera.K[0, 0]),
            centre_px=(float(camera.K[0, 2]), float(camera.K[1, 2])),
        )
        try:
            found.append(analyse(image, parameters))
        except NoNeedleError as error:
            return Refinement(status, error.reason)
    return found[0], found[1]


def _first_state(problem: Problem, T_wn: Pose) -> State:
    """Begin with the roll that explains the pictures best."""
    if problem.solid.revolution:
        return problem.start(T_wn)
    angles = 2 * np.pi * np.arange(ROLLS) / ROLLS
    tried = sorted((problem.start(rolled(T_wn, a)) for a in angles), key=lambda s: s.cost)
    followed = [problem.settle(state, FIRST_STEPS).state for state in tried[:BEST_ROLLS]]
    return min(followed, key=lambda s: s.cost)


def _judged(solution: Solution, solid: Solid, rig: StereoRig, ripples: Array) -> Refinement:
    state = solution.state
    left = np.array([fit.misfit for fit in state.fits])
    misfit = left * ripples
    if not solution.settled:
        return Refinement(RefineStatus.NOT_SETTLED, "the fit came to no end", misfit=misfit)
    if left.max() > GREATEST_MISFIT:
        return Refinement(
            RefineStatus.MISFIT,
            f"the pictures differ from the needle's by {misfit.max():.3g} times the noise's "
            f"variance, more than {GREATEST_MISFIT:g}: is it of this shape and size?",
            misfit=misfit,
        )
    tip = state.T_wn.apply(solid.apex)
    scale = max(1.0, float(left.max()))
    return Refinement(
        RefineStatus.OK,
        "",
        tip,
        solution.covariance[:3, :3] * scale,
        state.T_wn.R[:, 2].copy(),
        None if solid.revolution else roll_deg(state.T_wn),
        np.stack(rig.project(tip)),
        misfit,
    )
