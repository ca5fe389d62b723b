"""Lamps and the room."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator

from simtip.geometry import Array
from simtip.spec.base import NonNegative, Part, Positive, Rgb, Vector3, nonzero


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

    _along = field_validator("direction")(nonzero)

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
