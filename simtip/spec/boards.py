"""Calibration boards: what is printed on what, and how they are held before the cameras."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.errors import InputError
from simtip.plate import Plate
from simtip.spec.base import Fraction, Part, Positive
from simtip.target import parse_target

Scale = Annotated[FiniteFloat, Field(ge=0.8, le=1.25)]


class PlateSpec(Part):
    """The plate that carries the print, and what is wrong with it."""

    margin_mm: Annotated[
        FiniteFloat, Field(ge=0.5, le=1000, description="Bare plate around the pattern, mm.")
    ] = 6.0
    thickness_mm: Annotated[FiniteFloat, Field(ge=0.1, le=100, description="mm.")] = 3.0
    albedo: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Of the bare plate.")
    ] = (0.8, 0.8, 0.8)
    ink_albedo: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Of the printed parts.")
    ] = (0.04, 0.04, 0.04)
    edge_blur_mm: Annotated[
        FiniteFloat,
        Field(ge=0, le=1, description="Standard deviation of the softness of printed edges, mm."),
    ] = 0.01
    bow_mm: Annotated[
        FiniteFloat,
        Field(
            ge=-20,
            le=20,
            description=(
                "How far the plate's corners stand off the plane through its middle, away from "
                "the viewer, mm."
            ),
        ),
    ] = 0.0
    print_scale: Annotated[
        tuple[Scale, Scale], Field(description="Printed over nominal length, along x and y.")
    ] = (1.0, 1.0)

    @model_validator(mode="after")
    def _has_contrast(self) -> PlateSpec:
        if any(a == b for a, b in zip(self.albedo, self.ink_albedo, strict=True)):
            raise InputError(
                "is the plate's own albedo: the print cannot be seen",
                field="ink_albedo",
                remedy="give another albedo",
            )
        return self


class PosesSpec(Part):
    """Where the board is held, at random, seeded."""

    distance_mm: Annotated[
        Positive | None,
        Field(description="Camera z of the board's middle, left; null: the needle tip's."),
    ] = None
    depth_mm: Annotated[
        FiniteFloat, Field(ge=0, le=1e5, description="It varies by so much both ways, mm.")
    ] = 20.0
    tilt_deg: Annotated[
        tuple[FiniteFloat, FiniteFloat],
        Field(description="Least and most tilt off facing the middle of the two cameras, degrees."),
    ] = (5.0, 30.0)
    roll_deg: Annotated[
        FiniteFloat,
        Field(ge=0, le=180, description="Most rotation in the board's own plane, degrees."),
    ] = 20.0
    margin_px: Annotated[
        FiniteFloat,
        Field(ge=0, le=1e4, description="The plate stays so far inside of both images, px."),
    ] = 4.0
    max_blur_px: Annotated[
        Positive, Field(description="Largest circle of confusion on the pattern, px.")
    ] = 10.0

    @field_validator("tilt_deg")
    @classmethod
    def _tilts_in_order(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 0 <= value[0] <= value[1] <= 80:
            raise ValueError("tilts are two numbers from 0 to 80 degrees, the lesser first")
        return value


class BoardsSpec(Part):
    """Calibration images: what `simtip boards` renders of this scene's rig."""

    target: Annotated[
        str,
        Field(
            max_length=200,
            description="E.g. chessboard:11x8:6 (inner corners, mm), circles:11x8:6:3.",
        ),
    ] = "chessboard:11x8:6"
    views: Annotated[int, Field(ge=1, le=10_000, description="Pairs of images.")] = 20
    plate: PlateSpec = PlateSpec()
    poses: PosesSpec = PosesSpec()

    @field_validator("target")
    @classmethod
    def _is_target(cls, value: str) -> str:
        try:
            return str(parse_target(value))
        except InputError as error:  # its field is an option's; here the text is the field
            raise InputError(error.problem, remedy=error.remedy) from None

    def build(self) -> Plate:
        """Give the plate's geometry."""
        spec = self.plate
        return Plate(
            parse_target(self.target),
            margin_mm=spec.margin_mm,
            thickness_mm=spec.thickness_mm,
            bow_mm=spec.bow_mm,
            print_scale=spec.print_scale,
        )
