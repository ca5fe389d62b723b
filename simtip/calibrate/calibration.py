"""The outcome of a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.calibrate.corners import Corners
from simtip.calibrate.fundamental import EpipolarDistances
from simtip.calibrate.lens_model import LensModel
from simtip.calibrate.uncertainty import Deviations, Uncertainty
from simtip.camera import Camera, StereoRig
from simtip.geometry import Array, Pose


@dataclass(frozen=True)
class Rejected:
    """A view that was left out.

    Attributes
    ----------
    view
        Its name.
    reason
        Why, in one sentence with the numbers.
    """

    view: str
    reason: str


@dataclass(frozen=True)
class RejectedCorner:
    """A corner that was left out of a view that was kept.

    Attributes
    ----------
    view, camera
        Where.
    id
        Which of the target's points.
    residual_px
        How far it was seen from where the rig puts it, px.
    """

    view: str
    camera: str
    id: int
    residual_px: float


@dataclass(frozen=True, eq=False)
class Reprojection:
    """How well one camera's corners are explained.

    Attributes
    ----------
    corners
        Those used; their ``view`` indexes `Calibration.views_used`.
    residual_px
        (n, 2) seen less modelled, px of the image as it is.
    """

    corners: Corners
    residual_px: Array

    @property
    def rms_px(self) -> float:
        """Root mean square length of the residuals: the figure that OpenCV returns."""
        return float(np.sqrt((self.residual_px**2).sum(axis=1).mean()))

    @property
    def mean_px(self) -> float:
        """Mean length of the residuals."""
        return float(np.linalg.norm(self.residual_px, axis=1).mean())

    def of_view(self, index: int) -> Array:
        """Give the residuals (n, 2) of one view; n is 0 if this camera did not see it."""
        chosen: Array = self.residual_px[self.corners.view == index]
        return chosen


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated rig, what it was made from, and how good it is.

    Attributes
    ----------
    rig
        The cameras and ``T_lr``: ``P_l = R P_r + T``, paper Eq. 19. OpenCV's is the inverse.
    model
        The distortion model of both cameras.
    views_used
        Names of the views, those seen by one camera only among them.
    views_rejected
        The others, with reasons.
    corners_rejected
        Corners left out of views that were used.
    views_turned
        Views in which the right camera's points were numbered anew, by a symmetry of the target,
        to agree with the left one.
    board_poses
        (views used) board to left camera.
    left, right
        Reprojection errors of the joint fit.
    rms_alone_px
        RMS reprojection of the left and of the right camera calibrated alone, with free board
        poses, by robust weights. If the joint ``rms_px`` is much above, the pairs do not belong
        together: no common instant, a moving rig.
    uncertainty
        Covariance of all unknowns.
    std
        Standard deviations in the shapes of the results.
    epipolar, epipolar_raw
        Of all corner pairs, with F by the eight-point method: on undistorted pixels, as the rest of
        simtip has it, and on pixels as they are, as in the paper.
    epipolar_rig
        Of all corner pairs, undistorted, with the rig's own F.
    criterion
        Bayesian information criterion by model, if the model was chosen by it.
    warnings
        What the user ought to know besides.
    """

    rig: StereoRig
    model: LensModel
    views_used: tuple[str, ...]
    views_rejected: tuple[Rejected, ...]
    corners_rejected: tuple[RejectedCorner, ...]
    views_turned: tuple[str, ...]
    board_poses: tuple[Pose, ...]
    left: Reprojection
    right: Reprojection
    rms_alone_px: tuple[float, float]
    uncertainty: Uncertainty
    std: Deviations
    epipolar: EpipolarDistances
    epipolar_raw: EpipolarDistances
    epipolar_rig: EpipolarDistances
    criterion: dict[LensModel, float]
    warnings: tuple[str, ...]

    @property
    def baseline_mm(self) -> float:
        """Distance between the cameras, mm."""
        return float(np.linalg.norm(self.rig.T_lr.t))

    @property
    def rms_px(self) -> dict[str, float]:
        """RMS reprojection error, px: ``left``, ``right`` and, of all corners, ``stereo``."""
        both = np.concatenate([self.left.residual_px, self.right.residual_px])
        return {
            "left": self.left.rms_px,
            "right": self.right.rms_px,
            "stereo": float(np.sqrt((both**2).sum(axis=1).mean())),
        }

    def to_dict(self) -> dict[str, Any]:
        """Give all of it as plain values, for JSON.

        ``R`` and ``T_mm`` are those of ``P_left = R P_right + T`` (the paper's Eq. 19), not
        OpenCV's. ``F`` is the eight-point one, in the order ``p_left^T F p_right = 0``, of
        undistorted pixels, of unit Frobenius norm. ``epipolar_px`` gives the paper's Eq. 17.
        """
        return {
            "convention": "P_left = R P_right + T; p_left^T F p_right = 0, undistorted px",
            "model": self.model.value,
            "rms_px": self.rms_px,
            "mean_px": {"left": self.left.mean_px, "right": self.right.mean_px},
            "rms_alone_px": dict(zip(("left", "right"), self.rms_alone_px, strict=True)),
            "sigma_px": self.uncertainty.sigma_px,
            "degrees_of_freedom": self.uncertainty.degrees_of_freedom,
            "views_used": list(self.views_used),
            "views_rejected": [{"view": r.view, "reason": r.reason} for r in self.views_rejected],
            "views_turned": list(self.views_turned),
            "corners_rejected": [
                {"view": c.view, "camera": c.camera, "id": c.id, "residual_px": c.residual_px}
                for c in self.corners_rejected
            ],
            "per_view": [self._view(i) for i in range(len(self.views_used))],
            "K_left": self.rig.left.K.tolist(),
            "D_left": _coefficients(self.rig.left, self.model),
            "K_right": self.rig.right.K.tolist(),
            "D_right": _coefficients(self.rig.right, self.model),
            "R": self.rig.T_lr.R.tolist(),
            "T_mm": self.rig.T_lr.t.tolist(),
            "baseline_mm": self.baseline_mm,
            "std": {
                "K_left": self.std.K_left.tolist(),
                "D_left": self.std.D_left.tolist(),
                "K_right": self.std.K_right.tolist(),
                "D_right": self.std.D_right.tolist(),
                "R": self.std.R.tolist(),
                "rotation_deg": self.std.rotation_deg.tolist(),
                "T_mm": self.std.T_mm.tolist(),
                "baseline_mm": self.std.baseline_mm,
            },
            "F": self.epipolar.F.tolist(),
            "F_raw": self.epipolar_raw.F.tolist(),
            "F_rig": self.epipolar_rig.F.tolist(),
            "epipolar_px": self.epipolar.summary(),
            "epipolar_raw_px": self.epipolar_raw.summary(),
            "epipolar_rig_px": self.epipolar_rig.summary(),
            "criterion": {model.value: value for model, value in self.criterion.items()},
            "warnings": list(self.warnings),
        }

    def _view(self, index: int) -> dict[str, Any]:
        entry: dict[str, Any] = {"view": self.views_used[index]}
        for camera, reprojection in (("left", self.left), ("right", self.right)):
            residual = reprojection.of_view(index)
            lengths = np.linalg.norm(residual, axis=1)
            entry[camera] = (
                {
                    "points": len(residual),
                    "rms_px": float(np.sqrt((lengths**2).mean())),
                    "mean_px": float(lengths.mean()),
                    "max_px": float(lengths.max()),
                }
                if len(residual)
                else None
            )
        return entry


def _coefficients(camera: Camera, model: LensModel) -> list[float]:
    # a camera drops coefficients that are all zero
    return list(camera.distortion) or [0.0] * model.coefficients
