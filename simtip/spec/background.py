"""The board behind the needle."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from simtip.spec.base import Fraction, Part, Positive, Vector3, nonzero


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

    _normal = field_validator("normal")(nonzero)
