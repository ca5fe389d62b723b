"""The whole scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from simtip.spec.background import BackgroundSpec
from simtip.spec.base import Part, Positive
from simtip.spec.light import AmbientSpec, TubeLamp
from simtip.spec.needle import NeedleSpec
from simtip.spec.rig import RigSpec
from simtip.spec.sensor import SensorSpec

RESERVED = {"ambient", "needle"}
"""Light groups that are no lamps."""


class RenderSpec(Part):
    """How much work goes into the picture."""

    samples: Annotated[
        int,
        Field(
            ge=1, le=65536, description="Per pixel on and next to the needle; may be rounded up."
        ),
    ] = 256
    light_step_mm: Annotated[
        Positive, Field(description="Grid step of the background's illumination, mm.")
    ] = 0.5


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
    lamps: tuple[TubeLamp, ...] = ()
    ambient: AmbientSpec = AmbientSpec()
    sensor: SensorSpec = SensorSpec()
    render: RenderSpec = RenderSpec()
    detect: DetectSpec = DetectSpec()
    match: MatchSpec = MatchSpec()
    triangulate: TriangulateSpec = TriangulateSpec()

    @field_validator("lamps")
    @classmethod
    def _names_differ(cls, value: tuple[TubeLamp, ...]) -> tuple[TubeLamp, ...]:
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
