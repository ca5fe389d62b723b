"""What lies, sticks and hangs about where only a needle should be."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat, field_validator

from simtip.spec.base import Part, Positive

Level: TypeAlias = Literal["none", "light", "medium", "heavy", "hostile"]
Range: TypeAlias = tuple[float, float]

PositiveRange = tuple[Positive, Positive]
FractionRange = tuple[
    Annotated[FiniteFloat, Field(ge=0, le=1)], Annotated[FiniteFloat, Field(ge=0, le=1)]
]
Density = Annotated[FiniteFloat, Field(ge=0, le=1000)]
Spread = Annotated[FiniteFloat, Field(ge=0, le=1.5)]
Count = Annotated[int, Field(ge=0, le=50)]


@dataclass(frozen=True)
class ClutterAmounts:
    """How much of everything, with the level's figures filled in; see `ClutterSpec`."""

    specks_per_100cm2: float = 0.0
    speck_mm: float = 0.25
    speck_sigma: float = 0.6
    scratches_per_100cm2: float = 0.0
    scratch_mm: Range = (4.0, 40.0)
    scratch_width_mm: Range = (0.05, 0.25)
    hairs_per_100cm2: float = 0.0
    hair_mm: Range = (4.0, 30.0)
    hair_width_mm: Range = (0.05, 0.12)
    contrast: Range = (0.2, 0.8)
    scratch_contrast: Range = (0.05, 0.3)
    dust_per_100cm2: float = 0.0
    dust_mm: float = 0.3
    dust_sigma: float = 0.5
    cables: int = 0
    cable_diameter_mm: Range = (1.0, 4.0)
    rods: int = 0
    shadows: int = 0
    tip_clear_mm: float = 12.0

    def prints(self) -> bool:
        """Say whether anything is printed on the board."""
        return any((self.specks_per_100cm2, self.scratches_per_100cm2, self.hairs_per_100cm2))


LEVELS: dict[Level, ClutterAmounts] = {
    "none": ClutterAmounts(),
    "light": ClutterAmounts(
        specks_per_100cm2=3.0,
        speck_mm=0.2,
        speck_sigma=0.5,
        scratches_per_100cm2=0.1,
        hairs_per_100cm2=0.15,
        contrast=(0.1, 0.5),
        scratch_contrast=(0.03, 0.15),
        dust_per_100cm2=0.5,
        dust_mm=0.2,
        tip_clear_mm=20.0,
    ),
    "medium": ClutterAmounts(
        specks_per_100cm2=12.0,
        speck_mm=0.28,
        scratches_per_100cm2=0.4,
        hairs_per_100cm2=0.5,
        contrast=(0.15, 0.7),
        scratch_contrast=(0.05, 0.2),
        dust_per_100cm2=2.0,
        shadows=1,
    ),
    "heavy": ClutterAmounts(
        specks_per_100cm2=35.0,
        speck_mm=0.3,
        speck_sigma=0.7,
        scratches_per_100cm2=1.2,
        hairs_per_100cm2=1.2,
        contrast=(0.2, 0.85),
        scratch_contrast=(0.05, 0.35),
        dust_per_100cm2=5.0,
        dust_mm=0.35,
        cables=1,
        rods=1,
        shadows=1,
        tip_clear_mm=8.0,
    ),
    "hostile": ClutterAmounts(
        specks_per_100cm2=90.0,
        speck_mm=0.35,
        speck_sigma=0.8,
        scratches_per_100cm2=4.0,
        scratch_mm=(4.0, 80.0),
        scratch_width_mm=(0.05, 0.4),
        hairs_per_100cm2=3.0,
        contrast=(0.2, 0.95),
        scratch_contrast=(0.1, 0.6),
        dust_per_100cm2=12.0,
        dust_mm=0.4,
        dust_sigma=0.6,
        cables=3,
        rods=3,
        shadows=2,
        tip_clear_mm=0.0,
    ),
}
"""What the levels mean. The level decides every figure that a scene leaves out."""


class ClutterSpec(Part):
    """Things that are not the needle. `level` sets all amounts; a figure given here replaces its.

    Sizes that are `median` and `sigma` follow a log-normal distribution, pairs are the ends of a
    uniform one (lengths and widths: uniform in the logarithm).
    """

    level: Annotated[Level, Field(description="Preset of all the figures below.")] = "none"
    seed: Annotated[
        int | None,
        Field(ge=0, lt=2**63, description="Which clutter of this kind; none: by the scene's seed."),
    ] = None
    specks_per_100cm2: Annotated[
        Density | None, Field(description="Printed specks, mean number per 100 cm2 of board.")
    ] = None
    speck_mm: Annotated[
        FiniteFloat | None,
        Field(ge=0.02, le=5, description="Median diameter of a disc of the same area, mm."),
    ] = None
    speck_sigma: Annotated[
        Spread | None, Field(description="Standard deviation of the diameter's natural logarithm.")
    ] = None
    scratches_per_100cm2: Annotated[
        Density | None, Field(description="Scratches: straight or slightly bent, pointed lines.")
    ] = None
    scratch_mm: Annotated[
        PositiveRange | None, Field(description="Length of scratches, mm, at most 200.")
    ] = None
    scratch_width_mm: Annotated[
        PositiveRange | None, Field(description="Mean width of scratches, mm.")
    ] = None
    hairs_per_100cm2: Annotated[
        Density | None, Field(description="Hairs and fibres: thin bent lines.")
    ] = None
    hair_mm: Annotated[
        PositiveRange | None, Field(description="Length of hairs, mm, at most 200.")
    ] = None
    hair_width_mm: Annotated[PositiveRange | None, Field(description="Width of hairs, mm.")] = None
    contrast: Annotated[
        FractionRange | None,
        Field(description="How much darker than the board specks and hairs are; 1 is black."),
    ] = None
    scratch_contrast: Annotated[
        FractionRange | None, Field(description="Likewise of scratches.")
    ] = None
    dust_per_100cm2: Annotated[
        FiniteFloat | None,
        Field(
            ge=0,
            le=100,
            description=(
                "Solid grains on the board and, one in four, lint that hangs before it, mean "
                "number per 100 cm2 of seen board."
            ),
        ),
    ] = None
    dust_mm: Annotated[
        FiniteFloat | None, Field(ge=0.02, le=5, description="Median diameter of dust, mm.")
    ] = None
    dust_sigma: Annotated[
        Spread | None, Field(description="Standard deviation of its natural logarithm.")
    ] = None
    cables: Annotated[Count | None, Field(description="Bent cables across the view.")] = None
    cable_diameter_mm: Annotated[
        PositiveRange | None, Field(description="Of cables, mm, at most 20.")
    ] = None
    rods: Annotated[
        Count | None,
        Field(description="Straight gray rods about as thick as the needle, half of them pointed."),
    ] = None
    shadows: Annotated[
        Count | None,
        Field(description="Bars out of view that throw a shadow into it; needs a lamp."),
    ] = None
    tip_clear_mm: Annotated[
        FiniteFloat | None,
        Field(
            ge=0,
            le=1000,
            description=(
                "In both images dust, cables and rods stay this far from the tip, measured at the "
                "tip's distance, mm."
            ),
        ),
    ] = None
    occlude: Annotated[
        bool,
        Field(description="Cables, rods and lint may also hang before the needle and hide it."),
    ] = False

    @field_validator(
        "scratch_mm",
        "scratch_width_mm",
        "hair_mm",
        "hair_width_mm",
        "contrast",
        "scratch_contrast",
        "cable_diameter_mm",
    )
    @classmethod
    def _in_order(cls, value: Range | None) -> Range | None:
        if value is not None and value[0] > value[1]:
            raise ValueError(f"runs from {value[0]:g} down to {value[1]:g}: give the smaller first")
        return value

    @field_validator("scratch_mm", "hair_mm")
    @classmethod
    def _not_too_long(cls, value: Range | None) -> Range | None:
        if value is not None and value[1] > MAX_LINE_MM:
            raise ValueError(f"{value[1]:g} mm is too long: {MAX_LINE_MM:g} mm is the limit")
        return value

    @field_validator("scratch_width_mm", "hair_width_mm", "cable_diameter_mm")
    @classmethod
    def _not_too_wide(cls, value: Range | None) -> Range | None:
        if value is not None and value[1] > MAX_WIDTH_MM:
            raise ValueError(f"{value[1]:g} mm is too wide: {MAX_WIDTH_MM:g} mm is the limit")
        return value

    def amounts(self) -> ClutterAmounts:
        """Fill the level's figures in where none are given."""
        names = {field.name for field in fields(ClutterAmounts)}
        given = {name: getattr(self, name) for name in names}
        return replace(LEVELS[self.level], **{k: v for k, v in given.items() if v is not None})


MAX_LINE_MM = 200.0
"""Longest scratch or hair."""

MAX_WIDTH_MM = 20.0
"""Widest scratch, hair or cable."""
