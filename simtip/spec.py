"""The scene, as data: strict, frozen models of what a scene file may say.

World frame = left camera frame (x right, y down, z forward), millimetres. Loading from YAML, with
errors that name the line, is in `simtip.scene_file`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator, model_validator

from simtip.camera import Camera, StereoRig
from simtip.geometry import Array, Pose, nearest_rotation
from simtip.needle import Bevel, Cone, Needle

Coordinate = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Vector3 = tuple[Coordinate, Coordinate, Coordinate]
Cosine = Annotated[FiniteFloat, Field(ge=-1.01, le=1.01)]
Matrix3 = tuple[
    tuple[Cosine, Cosine, Cosine], tuple[Cosine, Cosine, Cosine], tuple[Cosine, Cosine, Cosine]
]
Rgb = tuple[
    Annotated[FiniteFloat, Field(ge=0)],
    Annotated[FiniteFloat, Field(ge=0)],
    Annotated[FiniteFloat, Field(ge=0)],
]
Positive = Annotated[FiniteFloat, Field(ge=1e-6, le=1e6)]
NonNegative = Annotated[FiniteFloat, Field(ge=0)]
Fraction = Annotated[FiniteFloat, Field(ge=0, le=1)]


RESERVED = {"ambient", "needle"}
"""Light groups that are no lamps."""

MAX_PIXELS = 100_000_000


def _direction(value: Vector3) -> Vector3:
    if not any(value):
        raise ValueError("a direction needs a length above zero")
    return value


class Part(BaseModel):
    """Base of all parts of a scene: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class CameraSpec(Part):
    """Intrinsics of one camera; pixel (0, 0) is the centre of the top-left pixel."""

    width: Annotated[int, Field(ge=1, le=32768, description="Full sensor width, px.")]
    height: Annotated[int, Field(ge=1, le=32768, description="Full sensor height, px.")]
    fx: Annotated[Positive, Field(description="Focal length along u, px.")]
    fy: Annotated[Positive, Field(description="Focal length along v, px.")]
    cx: Annotated[FiniteFloat, Field(description="Principal point u, px, on the full sensor.")]
    cy: Annotated[FiniteFloat, Field(description="Principal point v, px, on the full sensor.")]
    roi: Annotated[
        tuple[int, int, int, int] | None,
        Field(
            description=(
                "Region of interest read out: x, y, width, height in px of the full sensor. "
                "Images, truth and the exported rig then count pixels from its corner."
            )
        ),
    ] = None

    @model_validator(mode="after")
    def _roi_inside(self) -> CameraSpec:
        if self.roi is not None:
            x, y, w, h = self.roi
            if x < 0 or y < 0 or w < 1 or h < 1 or x + w > self.width or y + h > self.height:
                raise ValueError(
                    f"roi {list(self.roi)} does not lie in the {self.width}x{self.height} sensor"
                )
        width, height = self.roi[2:] if self.roi else (self.width, self.height)
        if width * height > MAX_PIXELS:
            raise ValueError(f"{width}x{height} px is too large: {MAX_PIXELS} pixels is the limit")
        return self

    def camera(self) -> Camera:
        """Build the camera, cropped to its region of interest."""
        K = np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])
        camera = Camera(K, self.width, self.height)
        return camera if self.roi is None else camera.cropped(*self.roi)


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


class ConeTip(Part):
    """A cone on the axis."""

    kind: Literal["cone"] = "cone"
    length_mm: Annotated[Positive, Field(description="From the apex to the full diameter, mm.")] = (
        5.0
    )


class BevelTip(Part):
    """A single plane cut, as on a hypodermic needle; the apex lies on the cylinder's surface."""

    kind: Literal["bevel"]
    angle_deg: Annotated[
        FiniteFloat, Field(ge=1, lt=90, description="Between the cut plane and the axis, degrees.")
    ] = 20.0


class NeedleMaterial(Part):
    """A rough metal: GGX microfacets over measured n and k."""

    metal: Annotated[
        Literal["titanium"], Field(description="Optical constants: Johnson and Christy 1974.")
    ] = "titanium"
    roughness: Annotated[FiniteFloat, Field(ge=0.01, le=1, description="GGX alpha.")] = 0.2


class NeedleSpec(Part):
    """The needle and where it is."""

    diameter_mm: Annotated[Positive, Field(description="Of the shaft, mm.")] = 1.67
    length_mm: Annotated[Positive, Field(description="From the apex to the hub's end, mm.")] = 150.0
    tip: Annotated[
        ConeTip | BevelTip, Field(discriminator="kind", description="The tip's shape.")
    ] = ConeTip()
    tip_mm: Annotated[Vector3, Field(description="The apex, world frame, mm.")]
    axis: Annotated[
        Vector3, Field(description="Direction from the tip to the hub, world frame, any length.")
    ] = (0.0, -1.0, 0.0)
    roll_deg: Annotated[
        FiniteFloat, Field(description="Right-handed turn about the axis, degrees.")
    ] = 0.0
    material: Annotated[NeedleMaterial, Field(description="What it is made of.")] = NeedleMaterial()

    _axis = field_validator("axis")(_direction)

    @model_validator(mode="after")
    def _tip_fits(self) -> NeedleSpec:
        self.needle()
        return self

    def needle(self) -> Needle:
        """Build the needle's geometry."""
        match self.tip:
            case ConeTip(length_mm=length_mm):
                return Needle(self.diameter_mm, self.length_mm, Cone(length_mm))
            case BevelTip(angle_deg=angle_deg):
                return Needle(self.diameter_mm, self.length_mm, Bevel(angle_deg))

    def pose(self) -> Pose:
        """Give T_wn, from the needle's frame to the world."""
        return self.needle().pose(self.tip_mm, self.axis, self.roll_deg)


class BackgroundSpec(Part):
    """A flat, matt board behind the needle."""

    centre_mm: Annotated[Vector3, Field(description="Of the board, world frame, mm.")] = (
        0.0,
        0.0,
        260.0,
    )
    normal: Annotated[Vector3, Field(description="Towards the cameras.")] = (0.0, 0.0, -1.0)
    size_mm: Annotated[
        tuple[Positive, Positive], Field(description="Width and height of the board, mm.")
    ] = (800.0, 800.0)
    albedo: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Diffuse reflectance, r g b.")
    ] = (0.8, 0.8, 0.8)

    _normal = field_validator("normal")(_direction)


class TubeLamp(Part):
    """A straight fluorescent tube: a cylinder that is equally bright all over."""

    name: Annotated[
        str,
        Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,31}$", description="Names its light group."),
    ]
    kind: Literal["tube"] = "tube"
    centre_mm: Annotated[Vector3, Field(description="Middle of the tube, world frame, mm.")]
    direction: Annotated[Vector3, Field(description="Along the tube, any length.")] = (
        1.0,
        0.0,
        0.0,
    )
    length_mm: Annotated[Positive, Field(description="Of the lit part, mm.")] = 1200.0
    diameter_mm: Annotated[Positive, Field(description="T5 16, T8 26, T12 38 mm.")] = 26.0
    radiant_power_w: Annotated[
        NonNegative, Field(description="Rated visible radiant power over the whole tube, W.")
    ] = 9.6
    power: Annotated[NonNegative, Field(description="Dimming; 1 is the rated power.")] = 1.0
    rgb: Annotated[Rgb, Field(description="Each channel's share of the power, relative.")] = (
        1.0,
        1.0,
        1.0,
    )

    _along = field_validator("direction")(_direction)

    @field_validator("rgb")
    @classmethod
    def _has_colour(cls, value: Rgb) -> Rgb:
        if not any(value):
            raise ValueError("a lamp without colour: set power to 0 to switch it off")
        return value

    def radiance(self) -> Array:
        """Give the tube's radiance per channel (3,), W m^-2 sr^-1.

        A matt emitter of power P and area A has the radiance P / (pi A); each of the three
        channels carries a third of the power, weighted by `rgb`.
        """
        area_m2 = np.pi * self.diameter_mm * self.length_mm * 1e-6
        share = np.array(self.rgb) / sum(self.rgb)
        radiance: Array = self.radiant_power_w * self.power * share / (np.pi * area_m2)
        return radiance


class AmbientSpec(Part):
    """Light that comes equally from everywhere else: the room's walls."""

    radiance_w_m2_sr: Annotated[
        Rgb, Field(description="Radiance of the surroundings per channel, W m^-2 sr^-1.")
    ] = (0.0, 0.0, 0.0)


class SensorSpec(Part):
    """What turns radiance into digital numbers; symbols as in EMVA 1288."""

    pixel_um: Annotated[Positive, Field(description="Pixel pitch, um; all of it collects.")] = 3.2
    f_number: Annotated[Positive, Field(description="Of the lens; sets the light, not the blur.")]
    exposure_s: Annotated[Positive, Field(le=100, description="Exposure time, s.")]
    wavelength_nm: Annotated[
        tuple[Positive, Positive, Positive], Field(description="Effective wavelength, nm, r g b.")
    ] = (600.0, 540.0, 460.0)
    quantum_efficiency: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Electrons per photon, r g b.")
    ] = (0.5, 0.5, 0.5)
    full_well_e: Annotated[
        FiniteFloat, Field(ge=1, description="Electrons a pixel holds before it clips.")
    ] = 10000.0
    read_noise_e: Annotated[
        NonNegative, Field(description="Temporal dark noise sigma_d, electrons RMS.")
    ] = 5.0
    gain_dn_per_e: Annotated[Positive, Field(description="Overall system gain K, DN/e-.")] = 0.0255
    black_level_dn: Annotated[NonNegative, Field(description="Added before rounding, DN.")] = 0.0
    bit_depth: Annotated[Literal[8], Field(description="Bits per channel.")] = 8
    noise: Annotated[bool, Field(description="Shot and read noise on or off.")] = True


class RenderSpec(Part):
    """How much work goes into the picture."""

    samples: Annotated[
        int,
        Field(
            ge=1, le=65536, description="Per pixel on and next to the needle; may be rounded up."
        ),
    ] = 64
    light_step_mm: Annotated[
        Positive, Field(description="Grid step of the background's illumination, mm.")
    ] = 0.5


class DetectSpec(BaseModel):
    """A detector's name and its parameters, which the detector itself declares and checks."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Annotated[str, Field(description="Which detector; its parameters stand beside it.")] = (
        "lin2020"
    )

    def parameters(self) -> dict[str, Any]:
        """Give the parameters as written in the scene."""
        return dict(self.model_extra or {})


class MatchSpec(Part):
    """Epipolar matching (paper section 3.3)."""

    max_distance_px: Annotated[
        Positive, Field(description="Largest accepted symmetric epipolar distance, px.")
    ] = 2.0


class TriangulateSpec(Part):
    """How two rays become one point."""

    method: Annotated[
        Literal["svd", "midpoint", "optimal"],
        Field(description="The paper's Eq. 22, nearest point, or least reprojection error."),
    ] = "svd"


class SceneSpec(Part):
    """One scene: what is seen, by what, in which light, and how it is measured."""

    name: Annotated[str, Field(max_length=200, description="For people.")] = "scene"
    seed: Annotated[int, Field(ge=0, lt=2**63, description="Root of all random numbers.")] = 0
    rig: RigSpec
    needle: NeedleSpec
    background: BackgroundSpec = BackgroundSpec()
    lamps: tuple[TubeLamp, ...] = ()
    ambient: AmbientSpec = AmbientSpec()
    sensor: SensorSpec
    render: RenderSpec = RenderSpec()
    detect: DetectSpec = DetectSpec()
    match: MatchSpec = MatchSpec()
    triangulate: TriangulateSpec = TriangulateSpec()

    @field_validator("lamps")
    @classmethod
    def _names_differ(cls, value: tuple[TubeLamp, ...]) -> tuple[TubeLamp, ...]:
        names = [lamp.name for lamp in value]
        twice = sorted({n for n in names if names.count(n) > 1} | (RESERVED & set(names)))
        if twice:
            raise ValueError(f"lamp name {twice[0]!r} is taken: each lamp needs its own")
        return value

    @model_validator(mode="after")
    def _is_lit(self) -> SceneSpec:
        if not self.lamps and not any(self.ambient.radiance_w_m2_sr):
            raise ValueError("there is no light: give lamps or ambient")
        return self
