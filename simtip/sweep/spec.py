"""What a sweep file says: a scene, what varies in it, how often, and what measures it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from simtip.errors import InputError

MOST_LEVELS = 100_000

MEASURED = "rig.measured"
"""A field of scenes that names a file."""


class SweepPart(BaseModel):
    """Base of all parts of a sweep file: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class RangeSpec(SweepPart):
    """Evenly spaced values, both ends included; or, sampled, anything in between."""

    low: Annotated[FiniteFloat, Field(alias="from", description="First value.")]
    high: Annotated[FiniteFloat, Field(alias="to", description="Last value.")]
    count: Annotated[int | None, Field(ge=2, le=MOST_LEVELS, description="How many values.")] = None
    step: Annotated[FiniteFloat | None, Field(gt=0, description="Or how far apart they are.")] = (
        None
    )
    log: Annotated[bool, Field(description="Evenly spaced in the logarithm.")] = False

    @model_validator(mode="after")
    def _makes_sense(self) -> RangeSpec:
        if self.high <= self.low:
            raise InputError("is not above from", field="to", remedy="give from < to")
        if self.log and self.low <= 0:
            raise InputError(
                "has no logarithm", field="from", remedy="give from > 0, or leave out log"
            )
        if self.count is not None and self.step is not None:
            raise InputError("stands beside count", field="step", remedy="give one of the two")
        if self.log and self.step is not None:
            raise InputError("has no meaning with log", field="step", remedy="give count")
        if self.step is not None and (self.high - self.low) / self.step > MOST_LEVELS:
            raise InputError(
                f"makes more than {MOST_LEVELS} values", field="step", remedy="make it larger"
            )
        return self


Levels = Annotated[list[Any], Field(min_length=1, max_length=MOST_LEVELS)]
Factor = RangeSpec | Levels


class GridSpec(SweepPart):
    """Every level of every factor with every level of the others."""

    kind: Literal["grid"] = "grid"


class SampledSpec(SweepPart):
    """Points spread over all factors at once; lists are sampled, too."""

    kind: Annotated[
        Literal["random", "sobol", "latin_hypercube"],
        Field(description="Independent, low-discrepancy, or one point in every stripe."),
    ]
    points: Annotated[int, Field(ge=1, le=10_000_000, description="How many.")]
    seed: Annotated[int, Field(ge=0, lt=2**63, description="Of the points.")] = 0


class DetectorEntry(SweepPart):
    """A detector with parameters of its own, under a label."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Annotated[str, Field(min_length=1, max_length=1000)]
    label: Annotated[
        str | None, Field(min_length=1, max_length=200, description="In the table.")
    ] = None

    def parameters(self) -> dict[str, Any]:
        """Give the parameters as written."""
        return dict(self.model_extra or {})


class SweepSpec(SweepPart):
    """A sweep."""

    scene: Annotated[str, Field(description="Scene file; counts from the sweep file's folder.")]
    base: Annotated[
        dict[str, Any], Field(description="Fields of the scene that are other than in its file.")
    ] = {}
    render_for: Annotated[
        dict[str, Any],
        Field(
            description=(
                "Fields that the light is rendered for, besides: those of other sweeps that ask "
                "for less noise, so that all share their renders."
            )
        ),
    ] = {}
    factors: Annotated[
        dict[str, Factor], Field(description="What varies: field of the scene, and its values.")
    ] = {}
    zipped: Annotated[
        list[dict[str, Levels]],
        Field(description="Groups of fields that vary together: lists of equal length."),
    ] = []
    design: Annotated[GridSpec | SampledSpec, Field(discriminator="kind")] = GridSpec()
    repeats: Annotated[
        int, Field(ge=1, le=1_000_000, description="Trials of every setting, each with new noise.")
    ] = 1
    detectors: Annotated[
        list[str | DetectorEntry] | None,
        Field(min_length=1, max_length=100, description="By default the scene's own."),
    ] = None
    seed: Annotated[
        int | None, Field(ge=0, lt=2**63, description="Of the noise; by default the scene's.")
    ] = None

    @model_validator(mode="after")
    def _varies_once(self) -> SweepSpec:
        for number, group in enumerate(self.zipped):
            lengths = {path: len(values) for path, values in group.items()}
            if len(set(lengths.values())) > 1:
                said = ", ".join(f"{path} {length}" for path, length in lengths.items())
                raise InputError(
                    f"has lists of different length ({said})",
                    field=f"zipped[{number}]",
                    remedy="give lists of equal length",
                )
        seen = set(self.factors)
        for number, group in enumerate(self.zipped):
            for path in group:
                if path in seen:
                    field = f"zipped[{number}].{path}"
                    raise InputError("varies twice", field=field, remedy="name it once")
            seen |= set(group)
        return self
