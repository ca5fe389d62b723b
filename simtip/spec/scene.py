"""The whole scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    field_validator,
    model_validator,
)

from simtip.spec.background import BackgroundSpec
from simtip.spec.base import Part, Positive
from simtip.spec.clutter import ClutterSpec
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
        Positive, Field(description="Grid step of the background's illumination, mm.")
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
            raise ValueError("there is no light: give lamps or ambient")
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
            raise ValueError(
                "render.crop fills up with a smooth background: not with clutter, paper or wrinkles"
            )
        return self

    @model_validator(mode="after")
    def _room_holds_all(self) -> SceneSpec:
        if self.room is None:
            return self
        places = {f"lamp {lamp.name}": lamp.centre_mm for lamp in self.lamps}
        places |= {"left camera": (0.0, 0.0, 0.0), "right camera": self.rig.t_mm}
        places |= {"background": self.background.centre_mm}
        for name, place in places.items():
            if not self.room.holds(place):
                raise ValueError(f"the {name} at {list(place)} mm stands outside the room")
        return self
