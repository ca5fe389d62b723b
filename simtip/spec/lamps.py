"""Lamps by their kind: tubes, troffers of tubes, panels, points."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from simtip.geometry import Array, unit
from simtip.spec.base import Positive, Vector3, nonzero
from simtip.spec.light import Lamp, TubeLamp


class TrofferLamp(Lamp):
    """Equal tubes side by side, one lamp to the switch; their housing is left out."""

    kind: Literal["troffer"]
    centre_mm: Annotated[Vector3, Field(description="Middle of all tubes, world frame, mm.")]
    direction: Annotated[Vector3, Field(description="Along the tubes, any length.")] = (
        1.0,
        0.0,
        0.0,
    )
    normal: Annotated[
        Vector3, Field(description="Across the plane of the tubes; world +y is down.")
    ] = (0.0, 1.0, 0.0)
    tubes: Annotated[int, Field(ge=2, le=16, description="How many.")] = 4
    spacing_mm: Annotated[Positive, Field(description="Between tube axes, mm.")] = 140.0
    length_mm: Annotated[Positive, Field(description="Of each tube's lit part, mm.")] = 600.0
    diameter_mm: Annotated[Positive, Field(description="T5 16, T8 26, T12 38 mm.")] = 16.0

    _along = field_validator("direction", "normal")(nonzero)

    @model_validator(mode="after")
    def _tubes_fit(self) -> TrofferLamp:
        _require_across(self.direction, self.normal)
        if self.spacing_mm <= self.diameter_mm:
            raise ValueError(
                f"spacing_mm {self.spacing_mm:g} has to be above diameter_mm {self.diameter_mm:g}: "
                "the tubes would touch"
            )
        return self

    @property
    def emitting_area_mm2(self) -> float:
        """All lit cylinders, without their ends, mm^2."""
        return float(np.pi * self.diameter_mm * self.length_mm * self.tubes)

    def outline_mm(self) -> Array:
        """Give the ends of the tubes' axes (2 tubes, 3)."""
        half = unit(np.array(self.direction)) * self.length_mm / 2
        return np.concatenate([self.tube_centres() - half, self.tube_centres() + half])

    def tube_centres(self) -> Array:
        """Give the tubes' middles, (tubes, 3) mm."""
        across = unit(np.cross(np.array(self.normal), np.array(self.direction)))
        steps = (np.arange(self.tubes) - (self.tubes - 1) / 2) * self.spacing_mm
        places: Array = np.array(self.centre_mm) + steps[:, None] * across
        return places


class PanelLamp(Lamp):
    """A flat, evenly bright, matt rectangle that shines to one side, such as an LED panel."""

    kind: Literal["panel"]
    centre_mm: Annotated[Vector3, Field(description="Middle of the panel, world frame, mm.")]
    normal: Annotated[Vector3, Field(description="To where it shines; world +y is down.")] = (
        0.0,
        1.0,
        0.0,
    )
    direction: Annotated[Vector3, Field(description="Along its first side, any length.")] = (
        1.0,
        0.0,
        0.0,
    )
    size_mm: Annotated[
        tuple[Positive, Positive], Field(description="Along and across `direction`, mm.")
    ] = (600.0, 600.0)

    _along = field_validator("direction", "normal")(nonzero)

    @model_validator(mode="after")
    def _has_a_plane(self) -> PanelLamp:
        _require_across(self.direction, self.normal)
        return self

    @property
    def emitting_area_mm2(self) -> float:
        """The lit side, mm^2."""
        return self.size_mm[0] * self.size_mm[1]

    def outline_mm(self) -> Array:
        """Give the corners (4, 3)."""
        normal = unit(np.array(self.normal))
        along = np.array(self.direction)
        x = unit(along - (along @ normal) * normal)
        y = np.cross(normal, x) * self.size_mm[1] / 2
        x = x * self.size_mm[0] / 2
        return np.array(self.centre_mm) + np.stack([x + y, x - y, -x + y, -x - y])


class PointLamp(Lamp):
    """A small bare lamp: its size makes its radiance, but no soft edge to a shadow."""

    kind: Literal["point"]
    centre_mm: Annotated[Vector3, Field(description="Where it is, world frame, mm.")]
    diameter_mm: Annotated[Positive, Field(description="Of the shining ball, mm.")] = 1.0

    @property
    def emitting_area_mm2(self) -> float:
        """The ball's surface, mm^2."""
        return float(np.pi * self.diameter_mm**2)

    def outline_mm(self) -> Array:
        """Give its middle (1, 3)."""
        return np.array([self.centre_mm])


LampSpec = Annotated[TubeLamp | TrofferLamp | PanelLamp | PointLamp, Field(discriminator="kind")]


def _require_across(direction: Vector3, normal: Vector3) -> None:
    if abs(unit(np.array(direction)) @ unit(np.array(normal))) > 0.999:
        raise ValueError("direction and normal have to be across each other")
