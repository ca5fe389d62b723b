"""The needle: shape and place."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.geometry import Pose
from simtip.needle import Bevel, Cone, Needle
from simtip.spec.base import Part, Positive, Vector3, nonzero
from simtip.spec.material import NeedleMaterial


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

    _axis = field_validator("axis")(nonzero)

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
