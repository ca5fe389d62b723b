"""The needle: shape and place."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.geometry import Pose
from simtip.needle import (
    BackBevel,
    Bevel,
    Blunt,
    Cone,
    Diamond,
    Franseen,
    Lancet,
    Needle,
    Tip,
    Trocar,
)
from simtip.spec.base import Part, Positive, Vector3, nonzero
from simtip.spec.material import NeedleMaterial

TipRadius = Annotated[
    FiniteFloat,
    Field(ge=0, le=1e3, description="Radius of the tip and of all its edges, mm; 0 is sharp."),
]
BevelAngle = Annotated[
    FiniteFloat, Field(ge=1, lt=90, description="Between the cut plane and the axis, degrees.")
]
PointAngle = Annotated[
    FiniteFloat, Field(ge=3, lt=90, description="Between each plane and the axis, degrees.")
]
Turn = Annotated[
    FiniteFloat,
    Field(ge=1, lt=90, description="Turn about the axis, either way, for the two planes, degrees."),
]


class ConeTip(Part):
    """A cone on the axis."""

    kind: Literal["cone"] = "cone"
    length_mm: Annotated[
        Positive, Field(description="From the sharp apex to the full diameter, mm.")
    ] = 5.0
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Cone(self.length_mm, self.tip_radius_mm)


class BevelTip(Part):
    """A single plane cut, as on a hypodermic needle; the apex lies on the cylinder's surface."""

    kind: Literal["bevel"]
    angle_deg: BevelAngle = 20.0
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Bevel(self.angle_deg, self.tip_radius_mm)


class BackBevelTip(Part):
    """A bevel with two grinds on its far side; the apex lies inside the cylinder's surface."""

    kind: Literal["back_bevel"]
    angle_deg: BevelAngle = 12.0
    back_angle_deg: BevelAngle = 18.0
    back_turn_deg: Turn = 35.0
    inset_share: Annotated[
        FiniteFloat,
        Field(ge=0.01, lt=1, description="How far the sharp tip lies inside the wall, of R."),
    ] = 0.25
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return BackBevel(
            self.angle_deg,
            self.back_angle_deg,
            self.back_turn_deg,
            self.inset_share,
            self.tip_radius_mm,
        )


class LancetTip(Part):
    """A bevel with two side bevels towards the tip, which lies on the cylinder's surface."""

    kind: Literal["lancet"]
    angle_deg: BevelAngle = 12.0
    side_angle_deg: BevelAngle = 18.0
    side_turn_deg: Turn = 35.0
    side_share: Annotated[
        FiniteFloat,
        Field(ge=0.05, lt=0.95, description="Side bevels' length, of the first bevel's 2 R / tan."),
    ] = 0.5
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Lancet(
            self.angle_deg,
            self.side_angle_deg,
            self.side_turn_deg,
            self.side_share,
            self.tip_radius_mm,
        )

    @model_validator(mode="after")
    def _is_a_lancet(self) -> LancetTip:
        self.shape()
        return self


class TrocarTip(Part):
    """Three equal planes that meet on the axis, the apex."""

    kind: Literal["trocar"]
    angle_deg: PointAngle = 20.0
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Trocar(self.angle_deg, self.tip_radius_mm)


class DiamondTip(Part):
    """Four equal planes that meet on the axis, the apex."""

    kind: Literal["diamond"]
    angle_deg: PointAngle = 20.0
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Diamond(self.angle_deg, self.tip_radius_mm)


class FranseenTip(Part):
    """A crown of three points around a bore; the apex is the one at needle +x."""

    kind: Literal["franseen"]
    angle_deg: PointAngle = 20.0
    bore_share: Annotated[
        FiniteFloat, Field(ge=0.05, lt=0.98, description="The bore's diameter, of the needle's.")
    ] = 0.72
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Franseen(self.angle_deg, self.bore_share, self.tip_radius_mm)


class BluntTip(Part):
    """A flat end; the apex is its middle."""

    kind: Literal["blunt"]
    tip_radius_mm: TipRadius = 0.0

    def shape(self) -> Tip:
        """Build the tip's geometry."""
        return Blunt(self.tip_radius_mm)


class NeedleSpec(Part):
    """The needle and where it is."""

    diameter_mm: Annotated[Positive, Field(description="Of the shaft, mm.")] = 1.67
    length_mm: Annotated[
        Positive, Field(description="From the apex to the hub's end, along the axis, mm.")
    ] = 150.0
    tip: Annotated[
        ConeTip
        | BevelTip
        | BackBevelTip
        | LancetTip
        | TrocarTip
        | DiamondTip
        | FranseenTip
        | BluntTip,
        Field(discriminator="kind", description="The tip's shape."),
    ] = ConeTip()
    bend_radius_mm: Annotated[
        Positive | None,
        Field(description="Of the arc that the axis follows, mm; null is straight."),
    ] = None
    bend_direction_deg: Annotated[
        FiniteFloat,
        Field(
            ge=-1e4,
            le=1e4,
            description="To which the hub is bent: azimuth about the axis from the needle's +x.",
        ),
    ] = 0.0
    tip_mm: Annotated[Vector3, Field(description="The apex, world frame, mm.")]
    axis: Annotated[
        Vector3,
        Field(
            description="Direction from the tip to the hub, world frame, any length; at the tip."
        ),
    ] = (0.0, -1.0, 0.0)
    roll_deg: Annotated[
        FiniteFloat, Field(description="Right-handed turn about the axis, degrees.")
    ] = 0.0
    material: Annotated[NeedleMaterial, Field(description="What it is made of.")] = NeedleMaterial()

    _axis = field_validator("axis")(nonzero)

    @model_validator(mode="after")
    def _is_possible(self) -> NeedleSpec:
        self.needle()
        return self

    def needle(self) -> Needle:
        """Build the needle's geometry."""
        return Needle(
            self.diameter_mm,
            self.length_mm,
            self.tip.shape(),
            self.bend_radius_mm,
            self.bend_direction_deg,
        )

    def pose(self) -> Pose:
        """Give T_wn, from the needle's frame to the world."""
        return self.needle().pose(self.tip_mm, self.axis, self.roll_deg)
