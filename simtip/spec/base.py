"""What all parts of a scene share."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Coordinate = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Vector3 = tuple[Coordinate, Coordinate, Coordinate]
Cosine = Annotated[FiniteFloat, Field(ge=-1.01, le=1.01)]
Matrix3 = tuple[
    tuple[Cosine, Cosine, Cosine], tuple[Cosine, Cosine, Cosine], tuple[Cosine, Cosine, Cosine]
]
Rgb = tuple[
    Annotated[FiniteFloat, Field(ge=0, le=1e9)],
    Annotated[FiniteFloat, Field(ge=0, le=1e9)],
    Annotated[FiniteFloat, Field(ge=0, le=1e9)],
]
Positive = Annotated[FiniteFloat, Field(ge=1e-6, le=1e6)]
NonNegative = Annotated[FiniteFloat, Field(ge=0, le=1e9)]
Fraction = Annotated[FiniteFloat, Field(ge=0, le=1)]


class Part(BaseModel):
    """Base of all parts of a scene: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def nonzero(value: Vector3) -> Vector3:
    """Refuse a direction without length."""
    if not any(value):
        raise ValueError("a direction needs a length above zero")
    return value
