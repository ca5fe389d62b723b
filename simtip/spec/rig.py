"""The cameras and the pose between them."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.camera import Camera, StereoRig, border, folds
from simtip.errors import InputError
from simtip.geometry import Array, Pose, nearest_rotation
from simtip.lens import ThinLens
from simtip.psf import Psf
from simtip.spec.base import Coordinate, Matrix3, Part, Positive, Vector3
from simtip.spec.sensor import SensorSpec
from simtip.undistort import TOLERANCE_PX, plan

MAX_PIXELS = 100_000_000

RENDERED_DISTORTIONS = (0, 4, 5, 8)
"""Numbers of coefficients: thin prism and tilt, which OpenCV adds, are not rendered."""

EDGE_STEP_PX = 8

MOST_LIGHT = 2.0
"""A vignetting polynomial may brighten the field up to this, times the axis."""

Coefficient = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]


class LensSpec(Part):
    """The lens of one camera. Without a focus distance it is a pinhole, sharp everywhere."""

    f_number: Annotated[
        FiniteFloat, Field(ge=0.5, le=1000, description="Focal length over entrance pupil.")
    ] = 1.4
    focal_length_mm: Annotated[Positive, Field(description="Sets the pupil's size, mm.")] = 6.0
    focus_mm: Annotated[
        Positive | None, Field(description="Camera z of the plane in focus, mm; none is a pinhole.")
    ] = None
    distortion: Annotated[
        tuple[Coefficient, ...],
        Field(
            description=(
                "Brown-Conrady in OpenCV's order: k1 k2 p1 p2 [k3 [k4 k5 k6]]; empty is none."
            )
        ),
    ] = ()
    cos4: Annotated[bool, Field(description="Natural vignetting, cos^4 of the field angle.")] = (
        False
    )
    vignetting: Annotated[
        tuple[Coefficient, ...],
        Field(
            max_length=4,
            description=(
                "Mechanical vignetting: a1 a2 .. of 1 + a1 t^2 + a2 t^4 + .., t the tangent of the "
                "field angle; empty is none."
            ),
        ),
    ] = ()
    diffraction: Annotated[
        bool, Field(description="Blur by the Airy pattern at the f-number and wavelength.")
    ] = False
    aberration_um: Annotated[
        FiniteFloat,
        Field(ge=0, le=100, description="Sigma of a Gaussian blur on the sensor, um."),
    ] = 0.0

    @field_validator("distortion")
    @classmethod
    def _has_a_length(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if len(value) not in RENDERED_DISTORTIONS:
            raise InputError(
                f"has {len(value)} coefficients: thin prism and tilt are not rendered"
                if len(value) > max(RENDERED_DISTORTIONS)
                else f"has {len(value)} coefficients",
                remedy="give 0, 4, 5 or 8 coefficients",
            )
        return value

    @model_validator(mode="after")
    def _focuses(self) -> LensSpec:
        if self.focus_mm is not None and self.focus_mm <= self.focal_length_mm:
            raise InputError(
                f"{self.focus_mm:g} mm lies inside the focal length: no image forms",
                field="focus_mm",
                remedy=f"give a distance above {self.focal_length_mm:g} mm, or none for a pinhole",
            )
        return self

    def thin_lens(self) -> ThinLens | None:
        """Give the finite aperture, or None for a pinhole."""
        if self.focus_mm is None:
            return None
        return ThinLens(self.focal_length_mm / self.f_number, self.focus_mm)

    def magnification(self) -> float:
        """Give m = f / (z_f - f) of the plane in focus; 0 for a pinhole."""
        if self.focus_mm is None:
            return 0.0
        return self.focal_length_mm / (self.focus_mm - self.focal_length_mm)

    def working_f_number(self) -> float:
        """Give N (1 + m), which counts for light and diffraction alike."""
        return self.f_number * (1 + self.magnification())

    def point_spread(self, sensor: SensorSpec) -> Psf:
        """Give the blur on a sensor.

        Raises
        ------
        InputError
            It is too wide; the field is this lens's.
        """
        return Psf(
            self.working_f_number(),
            sensor.wavelength_nm,
            sensor.pixel_um,
            self.aberration_um,
            self.diffraction,
        )

    def vignetting_at(self, t2: Array) -> Array:
        """Give the polynomial ``1 + a1 t^2 + a2 t^4 + ..`` at squared tangents of field angles."""
        kept = np.polynomial.polynomial.polyval(t2, (1.0, *self.vignetting))
        return np.asarray(kept, dtype=np.float64)


class CameraSpec(Part):
    """Intrinsics of one camera; pixel (0, 0) is the centre of the top-left pixel."""

    width: Annotated[int, Field(ge=1, le=32768, description="Full sensor width, px.")]
    height: Annotated[int, Field(ge=1, le=32768, description="Full sensor height, px.")]
    fx: Annotated[Positive, Field(description="Focal length along u, px.")]
    fy: Annotated[Positive, Field(description="Focal length along v, px.")]
    cx: Annotated[Coordinate, Field(description="Principal point u, px, on the full sensor.")]
    cy: Annotated[Coordinate, Field(description="Principal point v, px, on the full sensor.")]
    roi: Annotated[
        tuple[int, int, int, int] | None,
        Field(
            description=(
                "Region of interest read out: x, y, width, height in px of the full sensor. "
                "Images, truth and the exported rig then count pixels from its corner."
            )
        ),
    ] = None
    lens: Annotated[LensSpec, Field(description="Distortion and depth of field.")] = LensSpec()

    @model_validator(mode="after")
    def _roi_inside(self) -> CameraSpec:
        if self.roi is not None:
            x, y, w, h = self.roi
            if x < 0 or y < 0 or w < 1 or h < 1 or x + w > self.width or y + h > self.height:
                raise InputError(
                    f"roi {list(self.roi)} does not lie in the {self.width}x{self.height} sensor",
                    field="roi",
                    remedy="correct it: x, y, width, height in px of the full sensor",
                )
        width, height = self.roi[2:] if self.roi else (self.width, self.height)
        if width * height > MAX_PIXELS:
            raise InputError(
                f"{width}x{height} px is too large",
                field="roi" if self.roi else "width",
                remedy=f"read out at most {MAX_PIXELS} pixels",
            )
        return self

    @model_validator(mode="after")
    def _lens_serves_the_whole_image(self) -> CameraSpec:
        problem = _distortion_problem(self.camera(whole=True), self.camera())
        if problem:
            share = self._valid_share()
            weaker = f", or weaken it: times {share:.2f} it would do" if share else ""
            raise InputError(
                f"{list(self.lens.distortion)} {problem}",
                field="lens.distortion",
                remedy=f"calibrate the lens again{weaker}",
            )
        if self.lens.vignetting:
            self._check_vignetting()
        return self

    def _valid_share(self) -> float:
        """Find what the distortion may be multiplied by, rounded down to a hundredth."""
        whole = self.camera(whole=True)
        low, high = 0, 100
        while high - low > 1:
            middle = (low + high) // 2
            weaker = tuple(c * middle / 100 for c in self.lens.distortion)
            valid = not _distortion_problem(replace(whole, distortion=weaker))
            low, high = (middle, high) if valid else (low, middle)
        return low / 100

    def _check_vignetting(self) -> None:
        camera = self.camera(whole=True)
        edge = np.linalg.norm(camera.normalise(border(camera, EDGE_STEP_PX)), axis=1)
        nearest = 0.0 if camera.contains([self.cx, self.cy]) else float(edge.min())
        t = np.linspace(nearest, float(edge.max()), 257)
        kept = self.lens.vignetting_at(t**2)
        wrong = np.flatnonzero(~((kept > 0) & (kept <= MOST_LIGHT)))
        if len(wrong):
            raise InputError(
                f"leaves {kept[wrong[0]]:.4g} of the light at t = {t[wrong[0]]:.3g}",
                field="lens.vignetting",
                remedy=f"keep 1 + a1 t^2 + .. above 0 and at most {MOST_LIGHT:g} up to the corner, "
                f"t = {t[-1]:.3g}",
            )

    def camera(self, *, whole: bool = False) -> Camera:
        """Build the camera, cropped to its region of interest unless the whole is asked for."""
        K = np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])
        camera = Camera(K, self.width, self.height, self.lens.distortion)
        return camera if whole or self.roi is None else camera.cropped(*self.roi)


def _distortion_problem(whole: Camera, *parts: Camera) -> str | None:
    """Say what is wrong with a lens on the whole sensor, or on parts that are read out."""
    if not whole.distortion:
        return None
    if folds(whole):
        return "folds inside the image: the model is not valid out to its corners"
    if any(plan(camera).error_px > TOLERANCE_PX for camera in (whole, *parts)):
        return f"cannot be undone to {TOLERANCE_PX:g} px all over the image"
    return None


class RigSpec(Part):
    """Two cameras and the pose between them: ``p_left = R p_right + t`` (paper Eq. 19)."""

    left: Annotated[CameraSpec, Field(description="Its frame is the world frame.")]
    right: CameraSpec
    R: Annotated[
        Matrix3, Field(description="Right to left rotation, rows; made orthonormal by SVD.")
    ]
    t_mm: Annotated[Vector3, Field(description="Right camera's centre in the left frame, mm.")]
    measured: Annotated[
        str | None,
        Field(
            min_length=1,
            max_length=4096,
            description=(
                "File of another rig that measures, e.g. a calibration's; this one renders. "
                "Relative to the scene file. null: this one measures, too."
            ),
        ),
    ] = None

    @field_validator("R")
    @classmethod
    def _is_rotation(cls, value: Matrix3) -> Matrix3:
        nearest_rotation(value)
        return value

    @field_validator("t_mm")
    @classmethod
    def _has_baseline(cls, value: Vector3) -> Vector3:
        if not any(value):
            raise ValueError("the two cameras coincide: the baseline is 0 mm")
        return value

    def check_blur(self, sensor: SensorSpec) -> None:
        """Refuse point spreads that are too wide on a sensor, naming the field."""
        for side, camera in (("left", self.left), ("right", self.right)):
            try:
                camera.lens.point_spread(sensor)
            except InputError as error:
                field = f"rig.{side}.lens.{error.field}"
                raise InputError(error.problem, field=field, remedy=error.remedy) from None

    def rig(self) -> StereoRig:
        """Build the rig."""
        pose = Pose(nearest_rotation(self.R), np.array(self.t_mm))
        return StereoRig(self.left.camera(), self.right.camera(), pose)
