"""How much has to change before a change counts, however sure it is."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Tolerance(BaseModel):
    """Part of a suite: what is small enough to be left alone."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    bias_px: Annotated[
        float, Field(ge=0, le=1000, description="Least shift of the mean error that counts, px.")
    ] = 0.02
    bias_sigma: Annotated[
        float,
        Field(ge=0, le=100, description="Likewise, in standard deviations of the baseline."),
    ] = 0.5
    spread: Annotated[
        float, Field(ge=1, le=1000, description="Least ratio of standard deviations that counts.")
    ] = 1.25
    rate: Annotated[
        float, Field(ge=0, le=1, description="Least share of detections lost that counts.")
    ] = 0.01
    time: Annotated[
        float, Field(gt=1, le=1000, description="Least ratio of times that counts.")
    ] = 1.5
