"""The room around the scene, as far as the needle mirrors it and it lights the board."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from simtip.geometry import Array
from simtip.spec.base import Fraction, Part, Vector3


class RoomSpec(Part):
    """A box of matt walls, lit by the lamps directly; `ambient` is its many-times reflected light.

    World +y is down, so the ceiling is at the low y. What the needle and the board shade on the
    walls is left out.
    """

    low_mm: Annotated[Vector3, Field(description="Corner of least x, y, z, world frame, mm.")] = (
        -2500.0,
        -1700.0,
        -2500.0,
    )
    high_mm: Annotated[
        Vector3, Field(description="Corner of greatest x, y, z, world frame, mm.")
    ] = (2500.0, 1000.0, 2500.0)
    walls: Annotated[Fraction, Field(description="Albedo of the four walls; white 0.8.")] = 0.7
    ceiling: Annotated[Fraction, Field(description="Albedo of the ceiling.")] = 0.8
    floor: Annotated[Fraction, Field(description="Albedo of the floor.")] = 0.3

    @model_validator(mode="after")
    def _has_a_volume(self) -> RoomSpec:
        for axis, low, high in zip("xyz", self.low_mm, self.high_mm, strict=True):
            if not high - low >= 1:
                raise ValueError(
                    f"high_mm has to be 1 mm or more above low_mm in {axis}: {low:g} to {high:g}"
                )
        return self

    def holds(self, points_mm: Array) -> bool:
        """Say whether points (n, 3) of the world are all inside."""
        inside = (points_mm > np.array(self.low_mm)) & (points_mm < np.array(self.high_mm))
        return bool(inside.all())
