"""Calibrate a stereo rig from what its cameras saw of a flat target. Numbers only, no images.

    calibration = calibrate(views, target.points, (2048, 1436), (2048, 1436))
    print(calibration.to_dict())

Each camera is calibrated alone by Zhang's method (IEEE PAMI 22, 2000; the paper's section 3.1),
then both cameras, their relative pose and every board's pose by one least-squares adjustment, whose
covariance gives the standard deviations. `compare` judges the outcome against a true rig,
`error_map` says what it costs in millimetres.

The pose is ``T_lr``: ``P_left = R P_right + T`` (paper Eq. 19), R and T in `Calibration.to_dict`
likewise; OpenCV's is the inverse. A wrong square size scales the whole rig and all that it
measures, and no image shows it: hold the baseline against a ruler.
"""

from __future__ import annotations

from simtip.calibrate.calibration import Calibration, Rejected, RejectedCorner, Reprojection
from simtip.calibrate.compare import Comparison, Parameter, compare
from simtip.calibrate.corners import View
from simtip.calibrate.error_map import ErrorMap, error_map
from simtip.calibrate.fundamental import EpipolarDistances, as_printed, eight_point, epipolar_of
from simtip.calibrate.lens_model import LensModel
from simtip.calibrate.run import calibrate
from simtip.calibrate.uncertainty import Deviations, Uncertainty

__all__ = [
    "Calibration",
    "Comparison",
    "Deviations",
    "EpipolarDistances",
    "ErrorMap",
    "LensModel",
    "Parameter",
    "Rejected",
    "RejectedCorner",
    "Reprojection",
    "Uncertainty",
    "View",
    "as_printed",
    "calibrate",
    "compare",
    "eight_point",
    "epipolar_of",
    "error_map",
]
