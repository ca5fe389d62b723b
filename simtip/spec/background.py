"""The board behind the needle."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.spec.base import Fraction, Part, Positive, Vector3, nonzero

HEADROOM = 3.0
"""So many standard deviations of the paper's grain have to fit below an albedo of 1: what lies
beyond is clipped, which changes the mean by less than 4e-4 of the grain's contrast."""


class PaperTexture(Part):
    """Grain and cloudiness of paper: two isotropic Gaussian random fields about a mean of 1."""

    contrast: Annotated[
        FiniteFloat, Field(ge=0, le=0.2, description="Grain: standard deviation over mean albedo.")
    ] = 0.012
    correlation_mm: Annotated[
        FiniteFloat,
        Field(ge=0.2, le=50, description="Grain: autocorrelation falls to 1/e here, mm."),
    ] = 0.4
    mottle_contrast: Annotated[
        FiniteFloat, Field(ge=0, le=0.2, description="Cloudiness, likewise; 0 is none.")
    ] = 0.006
    mottle_mm: Annotated[
        FiniteFloat, Field(ge=1, le=500, description="Cloudiness: correlation length, mm.")
    ] = 6.0

    def rms(self) -> float:
        """Give the standard deviation of both together, over the mean albedo."""
        return float((self.contrast**2 + self.mottle_contrast**2) ** 0.5)


class Gradient(Part):
    """Albedo that changes smoothly over the board; its mean over the board stays as stated."""

    kind: Annotated[
        Literal["linear", "vignette"],
        Field(description="In one direction, or with the square of the distance from the centre."),
    ] = "linear"
    ratio: Annotated[
        FiniteFloat,
        Field(
            ge=0.05,
            le=20,
            description="Linear: last edge over first edge. Vignette: corner over centre.",
        ),
    ] = 0.8
    direction_deg: Annotated[
        FiniteFloat,
        Field(
            ge=-360,
            le=360,
            description=(
                "Linear: from the board's s axis towards its t axis. On a board that faces the "
                "left camera, 0 is left and 90 is down in the image."
            ),
        ),
    ] = 90.0
    span_mm: Annotated[
        Positive | None,
        Field(
            description=(
                "Linear: length about the board's centre over which the ratio is reached, mm; "
                "constant beyond. None: the whole board."
            )
        ),
    ] = None

    @model_validator(mode="after")
    def _vignette_spans_the_board(self) -> Gradient:
        if self.kind == "vignette" and self.span_mm is not None:
            raise ValueError("span_mm belongs to a linear gradient: a vignette spans the board")
        return self

    def swing(self) -> float:
        """Linear: give a of the factor 1 + a x, x from -1 to 1 over the span."""
        return (self.ratio - 1) / (self.ratio + 1)

    def peak(self) -> float:
        """Give the largest factor on the mean albedo."""
        if self.kind == "linear":
            return 1 + abs(self.swing())
        return max(1.0, self.ratio) * 3 / (2 + self.ratio)


class Wrinkles(Part):
    """A board that is not quite flat: only its normal tilts, it does not rise or fall."""

    rms_slope: Annotated[
        FiniteFloat,
        Field(ge=0, le=0.5, description="Undulation: RMS of the slope's magnitude, mm/mm."),
    ] = 0.05
    scale_mm: Annotated[
        FiniteFloat,
        Field(ge=2, le=500, description="Undulation: the height's correlation length (1/e), mm."),
    ] = 25.0
    folds: Annotated[
        int, Field(ge=0, le=50, description="Straight creases, each across the whole board.")
    ] = 0
    fold_slope: Annotated[
        FiniteFloat, Field(ge=0, le=1, description="Slope at both sides of a crease, mm/mm.")
    ] = 0.12


class BackgroundSpec(Part):
    """A flat, matt board behind the needle; `clutter` strews things on it."""

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
        tuple[Fraction, Fraction, Fraction],
        Field(description="Diffuse reflectance, r g b; with a texture, its mean over the board."),
    ] = (0.8, 0.8, 0.8)
    paper: Annotated[
        PaperTexture | None, Field(description="Grain of paper; none is even. {} takes defaults.")
    ] = None
    gradient: Annotated[Gradient | None, Field(description="Uneven albedo; none is even.")] = None
    wrinkles: Annotated[Wrinkles | None, Field(description="Uneven surface; none is flat.")] = None
    texture_seed: Annotated[
        int | None,
        Field(ge=0, lt=2**63, description="Which sheet of paper; none: by the scene's seed."),
    ] = None

    _normal = field_validator("normal")(nonzero)

    @model_validator(mode="after")
    def _stays_below_one(self) -> BackgroundSpec:
        peak = self.gradient.peak() if self.gradient else 1.0
        grain = self.paper.rms() if self.paper else 0.0
        brightest = max(self.albedo) * peak * (1 + HEADROOM * grain)
        if brightest > 1 and (self.paper or self.gradient):
            raise ValueError(
                f"albedo {max(self.albedo):g} with its texture reaches {brightest:.3g}, above 1: "
                "lower the albedo, the contrast or the gradient"
            )
        return self

    def textured(self) -> bool:
        """Say whether the albedo changes over the board."""
        return self.paper is not None or self.gradient is not None
