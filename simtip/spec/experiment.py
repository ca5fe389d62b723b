"""An experiment on a measuring system: a stage moves the needle, an interferometer tells how far.

As in Lin et al. (2020), sections 2.2 and 4: a robot of three axes carries the needle and the
interferometer's reflector, and the needle is driven along its first axis again and again.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.errors import InputError
from simtip.geometry import Array, unit
from simtip.spec.base import Part, Positive, Vector3, nonzero
from simtip.spec.recalibration import RecalibrationSpec

Length = Annotated[FiniteFloat, Field(ge=0, le=1e3)]

PARALLEL = 1e-6
"""Sine between two axes below which they do not span a plane."""


class StageSpec(Part):
    """A stage of three axes. The scene's needle is at `origin_mm` of its coordinates."""

    direction: Annotated[
        Vector3 | None,
        Field(description="Of the first axis, world; null: out of the hub past the tip."),
    ] = None
    second_direction: Annotated[
        Vector3 | None,
        Field(
            description=(
                "Of the second axis, made square to the first; null: as near to the left "
                "camera's x as can be. The third is square to both."
            )
        ),
    ] = None
    stroke_mm: Annotated[
        tuple[Positive, Positive, Positive], Field(description="Of each axis, from 0, mm.")
    ] = (28.0, 22.0, 15.0)
    origin_mm: Annotated[
        Vector3, Field(description="The stage's coordinates where the scene's needle is, mm.")
    ] = (0.0, 0.0, 0.0)
    resolution_mm: Annotated[
        Length, Field(description="Of its commands: it goes to whole multiples, mm; 0 is none.")
    ] = 0.000488
    positioning_mm: Annotated[
        Length,
        Field(description="Standard deviation of where it stops on the first axis, mm."),
    ] = 0.0
    backlash_mm: Annotated[
        Length,
        Field(description="Lost motion of the first axis when it turns round, mm."),
    ] = 0.0
    needle_play_mm: Annotated[
        FiniteFloat,
        Field(
            ge=-100,
            le=100,
            description=(
                "How much less the needle moves than the carriage with its reflector when the "
                "first axis turns round, mm; below 0 it moves more, as when the carriage tips over "
                "and the needle is off the beam (Abbe). The interferometer does not see it."
            ),
        ),
    ] = 0.0
    straightness_mm: Annotated[
        FiniteFloat,
        Field(
            ge=-100,
            le=100,
            description=(
                "How far the first axis bows towards the second one's direction in the middle of "
                "its stroke, from the line through its ends, mm."
            ),
        ),
    ] = 0.0
    overrun_mm: Annotated[
        Length,
        Field(description="It returns so far beyond a run's start, and comes to it forward, mm."),
    ] = 0.0

    @field_validator("direction", "second_direction")
    @classmethod
    def _is_a_direction(cls, value: Vector3 | None) -> Vector3 | None:
        return None if value is None else nonzero(value)

    def axes(self, needle_axis: Vector3) -> Array:
        """Give the three axes (3, 3), world, unit, as rows.

        Raises
        ------
        InputError
            The second direction is that of the first.
        """
        first = unit(np.array(self.direction) if self.direction else -np.array(needle_axis))
        if self.second_direction is not None:
            wanted = unit(np.array(self.second_direction))
        else:
            wanted = np.eye(3)[0 if abs(first[0]) < 0.9 else 2]
        across = wanted - (wanted @ first) * first
        if np.linalg.norm(across) < PARALLEL:
            raise InputError(
                "is that of the first axis",
                field="experiment.stage.second_direction",
                remedy="give another one",
            )
        second = unit(across)
        return np.stack([first, second, np.cross(first, second)])


class InterferometerSpec(Part):
    """A laser interferometer that measures along the first axis (Renishaw XL-80 by default)."""

    accuracy_ppm: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=1e4,
            description=(
                "Bounds of the error of its scale, um/m, that hold 95 % of runs: drawn once a run."
            ),
        ),
    ] = 0.5
    resolution_mm: Annotated[Length, Field(description="mm; 0 is none.")] = 1e-6
    misalignment_mrad: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=200,
            description="Between beam and first axis, mrad: it reads cos of it times the motion.",
        ),
    ] = 0.0
    dead_path_mm: Annotated[
        FiniteFloat,
        Field(ge=0, le=1e5, description="From the splitter to the reflector at its datum, mm."),
    ] = 0.0
    air_drift_ppm: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=100,
            description=(
                "Standard deviation of the air's refractive index, against the datum's, that is "
                "not made good over the dead path, ppm: drawn at every reading."
            ),
        ),
    ] = 0.0


class ScheduleSpec(Part):
    """What is driven and measured."""

    start_mm: Annotated[
        FiniteFloat, Field(ge=-1e3, le=1e3, description="Of every run, on the first axis, mm.")
    ] = 0.0
    step_mm: Annotated[Positive, Field(description="mm.")] = 2.0
    steps: Annotated[int, Field(ge=3, le=1000, description="Of a run.")] = 14
    runs: Annotated[int, Field(ge=2, le=1000, description="For agreement and repeatability.")] = 5
    accuracy_runs: Annotated[
        int, Field(ge=1, le=1000, description="Of these, the first so many for accuracy.")
    ] = 1
    accuracy_turns: Annotated[
        bool,
        Field(
            description=(
                "For accuracy every step is driven by itself: its start is come to backward, from "
                "its end. false: steps of the runs, one after the other."
            )
        ),
    ] = False
    setup_runs: Annotated[
        int, Field(ge=2, le=1000, description="Of every set-up, for gauge R&R.")
    ] = 2
    start_jitter_s: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=1,
            description=(
                "Every pair of images begins at a moment of its own, at random up to so long after "
                "sensor.start_s, s: where lamps ripple. 0 is a camera that the mains trigger."
            ),
        ),
    ] = 0.0
    registration: Annotated[
        tuple[int, int, int] | None,
        Field(
            description=(
                "Positions of each axis, over its stroke, for the registration of the stage's "
                "frame; null: none."
            )
        ),
    ] = (2, 2, 2)

    @model_validator(mode="after")
    def _fits(self) -> ScheduleSpec:
        for field in ("accuracy_runs", "setup_runs"):
            if getattr(self, field) > self.runs:
                raise InputError(
                    f"is more than the {self.runs} runs", field=field, remedy="give at most runs"
                )
        grid = self.registration
        if grid is not None and not (min(grid) >= 1 and sorted(grid)[1] >= 2 and max(grid) <= 20):
            raise InputError(
                "makes no plane or volume",
                field="registration",
                remedy="give 2 to 20 positions on at least two axes, 1 on the third if at all",
            )
        return self


class SetupSpec(Part):
    """One set-up of the system: an "operator" of gauge R&R."""

    name: Annotated[str, Field(min_length=1, max_length=100, description="For people.")]
    set: Annotated[
        dict[str, Any],
        Field(
            default_factory=dict,
            description='Fields of the scene that are other, e.g. {"lamps[0].power": 1.1}.',
        ),
    ]
    recalibrate: Annotated[
        RecalibrationSpec | None,
        Field(description="Measured with a rig calibrated anew; null: with the scene's."),
    ] = None

    @model_validator(mode="after")
    def _differs(self) -> SetupSpec:
        for path in self.set:
            if path.split(".")[0].split("[")[0] in {"experiment", "needle"} or path == "seed":
                raise InputError(
                    f"changes {path}",
                    field="set",
                    remedy="change lamps, lenses, sensor or detector: the stage moves the needle",
                )
        return self


class ExperimentSpec(Part):
    """The experiment: what is moved, by what it is checked, how often, and in which set-ups."""

    stage: StageSpec = StageSpec()
    interferometer: InterferometerSpec = InterferometerSpec()
    schedule: ScheduleSpec = ScheduleSpec()
    calibration: Annotated[
        RecalibrationSpec | None,
        Field(description="How the measuring rig was calibrated; null: `rig.measured`, or true."),
    ] = None
    setups: Annotated[
        tuple[SetupSpec, ...],
        Field(max_length=50, description="Besides the scene's own, for gauge R&R."),
    ] = ()
    tolerance_mm: Annotated[
        Positive, Field(description="USL - LSL of a displacement, mm, for P/T.")
    ] = 0.62
    multiplier: Annotated[
        Positive, Field(description="Of P/T: 6, or 5.15 as AIAG had it of old.")
    ] = 6.0
    level: Annotated[
        FiniteFloat, Field(ge=0.5, le=0.9999, description="Confidence level of all intervals.")
    ] = 0.95

    @model_validator(mode="after")
    def _stays_within_the_stroke(self) -> ExperimentSpec:
        plan, stroke = self.schedule, self.stage.stroke_mm[0]
        last = plan.start_mm + plan.steps * plan.step_mm
        if plan.start_mm < 0 or last > stroke * (1 + 1e-9):
            raise InputError(
                f"goes from {plan.start_mm:g} to {last:g} mm, beyond the stroke of {stroke:g} mm",
                field="schedule.steps",
                remedy="make fewer or shorter steps, or give a longer stage.stroke_mm",
            )
        return self

    @field_validator("setups")
    @classmethod
    def _names_differ(cls, value: tuple[SetupSpec, ...]) -> tuple[SetupSpec, ...]:
        names = [*RESERVED, *(one.name for one in value)]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"set-up name {twice[0]!r} is taken: each needs its own")
        return value


OWN_SETUP = "as in the scene"
"""Name of the scene's own set-up."""

RESERVED = (OWN_SETUP, "accuracy", "registration")
"""Names that no other set-up may have."""
