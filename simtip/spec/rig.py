"""The cameras and the pose between them."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.camera import Camera, StereoRig, folds
from simtip.geometry import Pose, nearest_rotation
from simtip.lens import ThinLens
from simtip.spec.base import Coordinate, Matrix3, Part, Positive, Vector3

MAX_PIXELS = 100_000_000

RENDERED_DISTORTIONS = (0, 4, 5, 8)
"""Numbers of coefficients: thin prism and tilt, which OpenCV adds, are not rendered."""


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
        tuple[FiniteFloat, ...],
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
        tuple[FiniteFloat, ...],
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
            raise ValueError(f"takes {RENDERED_DISTORTIONS} coefficients, not {len(value)}")
        return value

    @model_validator(mode="after")
    def _focuses(self) -> LensSpec:
        if self.focus_mm is not None and self.focus_mm <= self.focal_length_mm:
            raise ValueError(
                f"focus_mm = {self.focus_mm:g} lies inside the focal length of "
                f"{self.focal_length_mm:g} mm: no image forms"
            )
        return self

    def thin_lens(self) -> ThinLens | None:
        """Give the finite aperture, or None for a pinhole."""
        if self.focus_mm is None:
            return None
        return ThinLens(self.focal_length_mm / self.f_number, self.focus_mm)


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
                raise ValueError(
                    f"roi {list(self.roi)} does not lie in the {self.width}x{self.height} sensor"
                )
        if folds(self.camera(whole=True)):
            raise ValueError(
                f"lens.distortion {list(self.lens.distortion)} folds inside the image: the model "
                "is not valid out to its corners"
            )
        width, height = self.roi[2:] if self.roi else (self.width, self.height)
        if width * height > MAX_PIXELS:
            raise ValueError(f"{width}x{height} px is too large: {MAX_PIXELS} pixels is the limit")
        return self

    def camera(self, *, whole: bool = False) -> Camera:
        """Build the camera, cropped to its region of interest unless the whole is asked for."""
        K = np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])
        camera = Camera(K, self.width, self.height, self.lens.distortion)
        return camera if whole or self.roi is None else camera.cropped(*self.roi)


class RigSpec(Part):
    """Two cameras and the pose between them: ``p_left = R p_right + t`` (paper Eq. 19)."""

    left: Annotated[CameraSpec, Field(description="Its frame is the world frame.")]
    right: CameraSpec
    R: Annotated[
        Matrix3, Field(description="Right to left rotation, rows; made orthonormal by SVD.")
    ]
    t_mm: Annotated[Vector3, Field(description="Right camera's centre in the left frame, mm.")]

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

    def rig(self) -> StereoRig:
        """Build the rig."""
        pose = Pose(nearest_rotation(self.R), np.array(self.t_mm))
        return StereoRig(self.left.camera(), self.right.camera(), pose)
