"""The whole scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    field_validator,
    model_validator,
)

from simtip.errors import InputError
from simtip.spec.background import BackgroundSpec
from simtip.spec.base import Part, Positive
from simtip.spec.boards import BoardsSpec
from simtip.spec.clutter import ClutterSpec
from simtip.spec.experiment import ExperimentSpec
from simtip.spec.lamps import LampSpec
from simtip.spec.light import AmbientSpec
from simtip.spec.needle import NeedleSpec
from simtip.spec.rig import RigSpec
from simtip.spec.room import RoomSpec
from simtip.spec.sensor import SensorSpec

RESERVED = {"ambient", "needle", "clutter"}
"""Names of layers that are no lamps."""


class RenderSpec(Part):
    """How much work goes into the picture."""

    noise: Annotated[
        FiniteFloat | None,
        Field(
            ge=0.01,
            le=100,
            description=(
                "Monte-Carlo noise asked for, times the sensor's own noise at that pixel; null: "
                "every pixel that needs sampling takes `samples`."
            ),
        ),
    ] = 0.3
    samples: Annotated[
        int,
        Field(
            ge=1,
            le=16384,
            description=(
                "Per pixel on and next to the needle, lamps and clutter: with `noise` the most "
                "that are spent. Rounded up to a multiple of 4."
            ),
        ),
    ] = 4096
    light_step_mm: Annotated[
        FiniteFloat,
        Field(ge=0.05, le=20, description="Grid step of the background's illumination, mm."),
    ] = 0.5
    crop: Annotated[
        bool,
        Field(
            description=(
                "Work out the background's light on a coarse grid only, but near the needle: "
                "quicker, without the needle's shadow elsewhere. Not with clutter."
            )
        ),
    ] = False


class DetectSpec(BaseModel):
    """A detector's name and its parameters, which the detector itself declares and checks."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Annotated[str, Field(description="Which detector; its parameters stand beside it.")] = (
        "lin2020"
    )

    def parameters(self) -> dict[str, Any]:
        """Give the parameters as written in the scene."""
        return dict(self.model_extra or {})


class MatchSpec(Part):
    """Epipolar matching (paper section 3.3)."""

    max_distance_px: Annotated[
        Positive, Field(description="Largest accepted symmetric epipolar distance, px.")
    ] = 2.0


class TriangulateSpec(Part):
    """How two rays become one point."""

    method: Annotated[
        Literal["svd", "midpoint", "optimal"],
        Field(description="The paper's Eq. 22, nearest point, or least reprojection error."),
    ] = "svd"


class RefineSpec(Part):
    """What follows triangulation."""

    name: Annotated[
        Literal["none", "silhouette"],
        Field(
            description=(
                "silhouette: the needle, its shape known, is fitted to both images at once. For "
                "straight, convex needles."
            )
        ),
    ] = "none"


class SceneSpec(Part):
    """One scene: what is seen, by what, in which light, and how it is measured."""

    name: Annotated[str, Field(max_length=200, description="For people.")] = "scene"
    seed: Annotated[int, Field(ge=0, lt=2**63, description="Root of all random numbers.")] = 0
    rig: RigSpec
    needle: NeedleSpec
    background: BackgroundSpec = BackgroundSpec()
    clutter: ClutterSpec = ClutterSpec()
    lamps: tuple[LampSpec, ...] = ()
    ambient: AmbientSpec = AmbientSpec()
    room: Annotated[
        RoomSpec | None,
        Field(description="Walls; null: only the ambient light. {} takes defaults."),
    ] = None
    sensor: SensorSpec = SensorSpec()
    render: RenderSpec = RenderSpec()
    detect: DetectSpec = DetectSpec()
    match: MatchSpec = MatchSpec()
    triangulate: TriangulateSpec = TriangulateSpec()
    refine: RefineSpec = RefineSpec()
    boards: BoardsSpec = BoardsSpec()
    experiment: ExperimentSpec = ExperimentSpec()

    @field_validator("lamps")
    @classmethod
    def _names_differ(cls, value: tuple[LampSpec, ...]) -> tuple[LampSpec, ...]:
        names = [lamp.name for lamp in value]
        twice = sorted({n for n in names if names.count(n) > 1} | (RESERVED & set(names)))
        if twice:
            raise ValueError(f"lamp name {twice[0]!r} is taken: each lamp needs its own")
        return value

    @model_validator(mode="after")
    def _is_lit(self) -> SceneSpec:
        if not self.lamps and not any(self.ambient.radiance_w_m2_sr):
            raise InputError(
                "there is no light", field="lamps", remedy="give lamps or ambient.radiance_w_m2_sr"
            )
        return self

    @model_validator(mode="after")
    def _blur_is_small(self) -> SceneSpec:
        self.rig.check_blur(self.sensor)
        return self

    @model_validator(mode="after")
    def _crop_shows_nothing_else(self) -> SceneSpec:
        board, amounts = self.background, self.clutter.amounts()
        uneven = board.textured() or board.wrinkles is not None
        if self.render.crop and (uneven or amounts != type(amounts)()):
            raise InputError(
                "fills up with a smooth background: not with clutter, paper, gradient or wrinkles",
                field="render.crop",
                remedy="leave it out, or make the background plain",
            )
        return self

    @model_validator(mode="after")
    def _room_holds_all(self) -> SceneSpec:
        if self.room is None:
            return self
        places = {f"lamp {lamp.name}": lamp.outline_mm() for lamp in self.lamps}
        places["left camera"] = np.zeros((1, 3))
        places["right camera"] = np.array([self.rig.t_mm])
        places["background"] = np.array([self.background.centre_mm])
        needle = self.needle.needle()
        places["needle"] = self.needle.pose().apply(needle.surface(8)[0])
        for name, points in places.items():
            if not self.room.holds(points):
                raise InputError(
                    f"does not hold the {name}, which reaches from "
                    f"{points.min(axis=0).round(1).tolist()} to "
                    f"{points.max(axis=0).round(1).tolist()} mm",
                    field="room",
                    remedy="widen low_mm and high_mm, or move what stands outside",
                )
        return self
