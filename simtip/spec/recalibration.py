"""A calibration as a user would make it, in numbers: how many views, how noisy, by which model."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from simtip.spec.base import Part


class RecalibrationSpec(Part):
    """What a calibration of the scene's rig is made from; the board is the scene's `boards`."""

    views: Annotated[int, Field(ge=3, le=200, description="Pairs of images of the board.")] = 20
    corner_noise_px: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=5,
            description="Standard deviation of each u and each v of a point of the board, px.",
        ),
    ] = 0.05
    distortion: Annotated[
        Literal["none", "radial2", "radtan", "opencv5", "rational", "auto"],
        Field(description="Lens model that is fitted, as in `simtip calibrate --model`."),
    ] = "opencv5"
    print_scale_error: Annotated[
        FiniteFloat,
        Field(
            ge=-0.2,
            le=0.25,
            description=(
                "Printed size of the board over the size that the calibration is told, less 1, "
                "with `boards.plate.print_scale` told: lengths are measured 1 + this too small."
            ),
        ),
    ] = 0.0
    seed: Annotated[
        int, Field(ge=0, lt=2**63, description="Of the poses and of the noise; not the scene's.")
    ] = 0
