"""A calibration against the rig that was truly there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from simtip.calibrate.calibration import Calibration
from simtip.calibrate.uncertainty import INTRINSICS, RELATIVE
from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Array


@dataclass(frozen=True)
class Parameter:
    """One parameter, measured and true.

    Attributes
    ----------
    name
        ``left.fx`` ... ``right.k6``, ``rotation_x_deg`` ..., ``T_x_mm`` ..., ``baseline_mm``.
    true, measured
        In the unit of the name; px for ``fx fy cx cy``. A rotation is that of the measured right
        camera after the true one, about the left camera's axes: true 0.
    error
        Measured less true.
    std
        Standard deviation that the calibration claims; 0 if the model holds the parameter at 0.
    """

    name: str
    true: float
    measured: float
    error: float
    std: float

    @property
    def z(self) -> float | None:
        """Error in standard deviations; None of what was not estimated."""
        return self.error / self.std if self.std > 0 else None


@dataclass(frozen=True, eq=False)
class Comparison:
    """Every parameter against its true value.

    Attributes
    ----------
    parameters
        All of them.
    focal_percent
        (4,) errors of fx, fy of the left, fx, fy of the right camera, percent of the true ones.
    principal_point_px
        (4,) errors of cx, cy, likewise, px.
    rotation_deg
        Angle between the measured and the true R, degrees, at least 0.
    translation_mm
        (3,) errors of T.
    baseline_mm
        Error of its length.
    mahalanobis
        Error of all estimated parameters at once, correlations included: the root of
        ``e^T C^-1 e / n``, near 1 if the claimed covariance is right; None if a parameter that was
        held at zero is not truly zero.
    """

    parameters: tuple[Parameter, ...]
    focal_percent: Array
    principal_point_px: Array
    rotation_deg: float
    translation_mm: Array
    baseline_mm: float
    mahalanobis: float | None

    def __getitem__(self, name: str) -> Parameter:
        return next(p for p in self.parameters if p.name == name)

    def to_dict(self) -> dict[str, Any]:
        """Give all of it as plain values, for JSON."""
        return {
            "focal_percent": {
                name: float(x)
                for name, x in zip(
                    ("left.fx", "left.fy", "right.fx", "right.fy"), self.focal_percent, strict=True
                )
            },
            "principal_point_px": {
                name: float(x)
                for name, x in zip(
                    ("left.cx", "left.cy", "right.cx", "right.cy"),
                    self.principal_point_px,
                    strict=True,
                )
            },
            "rotation_deg": self.rotation_deg,
            "T_mm": self.translation_mm.tolist(),
            "baseline_mm": self.baseline_mm,
            "mahalanobis": self.mahalanobis,
            "parameters": {
                p.name: {
                    "true": p.true,
                    "measured": p.measured,
                    "error": p.error,
                    "std": p.std,
                    "z": p.z,
                }
                for p in self.parameters
            },
        }


def compare(calibration: Calibration, true: StereoRig) -> Comparison:
    """Compare every parameter of a calibration with the true rig; error = measured - true.

    Raises
    ------
    InputError
        The true rig has images of another size, or lenses that the models do not describe.
    """
    rig, std = calibration.rig, calibration.uncertainty
    parameters = []
    for name, camera, truly in (("left", rig.left, true.left), ("right", rig.right, true.right)):
        if camera.size != truly.size:
            raise InputError(
                f"the true {name} images are {truly.width} x {truly.height} px, the calibrated "
                f"ones {camera.width} x {camera.height} px",
                field="truth",
                remedy="give the truth of these images",
            )
        for key, x, y in zip(
            INTRINSICS, _numbers(truly, name), _numbers(camera, name), strict=True
        ):
            full = f"{name}.{key}"
            claimed = std.std(full) if full in std.names else 0.0
            parameters.append(Parameter(full, float(x), float(y), float(y - x), claimed))
    turn = Rotation.from_matrix(rig.T_lr.R @ true.T_lr.R.T).as_rotvec(degrees=True)
    shift = rig.T_lr.t - true.T_lr.t
    for k, axis in enumerate("xyz"):
        angle, claimed = float(turn[k]), float(calibration.std.rotation_deg[k])
        parameters.append(Parameter(f"rotation_{axis}_deg", 0.0, angle, angle, claimed))
    for k, axis in enumerate("xyz"):
        parameters.append(
            Parameter(
                f"T_{axis}_mm",
                float(true.T_lr.t[k]),
                float(rig.T_lr.t[k]),
                float(shift[k]),
                float(calibration.std.T_mm[k]),
            )
        )
    length = float(np.linalg.norm(true.T_lr.t))
    off = calibration.baseline_mm - length
    parameters.append(
        Parameter("baseline_mm", length, calibration.baseline_mm, off, calibration.std.baseline_mm)
    )
    by_name = {p.name: p for p in parameters}
    return Comparison(
        parameters=tuple(parameters),
        focal_percent=np.array(
            [
                100 * by_name[f"{c}.{f}"].error / by_name[f"{c}.{f}"].true
                for c in ("left", "right")
                for f in ("fx", "fy")
            ]
        ),
        principal_point_px=np.array(
            [by_name[f"{c}.{p}"].error for c in ("left", "right") for p in ("cx", "cy")]
        ),
        rotation_deg=float(np.linalg.norm(turn)),
        translation_mm=shift,
        baseline_mm=off,
        mahalanobis=_mahalanobis(calibration, by_name),
    )


def _mahalanobis(calibration: Calibration, by_name: dict[str, Parameter]) -> float | None:
    names = calibration.uncertainty.names
    if any(p.error and not p.std for p in by_name.values()):
        return None
    errors = []
    for name in names:
        if name in by_name:
            errors.append(by_name[name].error)
        elif name in RELATIVE[:3]:
            errors.append(float(np.radians(by_name[f"{name}_deg"].error)))
        else:
            errors.append(by_name[f"{name}_mm"].error)
    C = calibration.uncertainty.covariance
    unit = 1 / np.sqrt(np.diagonal(C))
    e = np.array(errors) * unit
    return float(np.sqrt(e @ np.linalg.solve(C * unit[:, None] * unit, e) / len(e)))


def _numbers(camera: Camera, name: str) -> Array:
    coefficients = camera.distortion
    if any(coefficients[8:]):
        raise InputError(
            f"the true {name} lens has thin-prism or tilt coefficients, which no model here has",
            field="truth",
            remedy="compare with a rig of up to eight coefficients",
        )
    K = camera.K
    table = np.zeros(len(INTRINSICS))
    table[:4] = K[0, 0], K[1, 1], K[0, 2], K[1, 2]
    table[4 : 4 + min(len(coefficients), 8)] = coefficients[:8]
    return table
