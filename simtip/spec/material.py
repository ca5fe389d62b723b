"""What the needle is made of."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from simtip.spec.base import Part


class NeedleMaterial(Part):
    """A rough metal: GGX microfacets over measured n and k."""

    metal: Annotated[
        Literal["titanium"], Field(description="Optical constants: Johnson and Christy 1974.")
    ] = "titanium"
    roughness: Annotated[FiniteFloat, Field(ge=0.01, le=1, description="GGX alpha.")] = 0.2
