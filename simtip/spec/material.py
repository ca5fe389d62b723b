"""What the needle is made of."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat

from simtip.spec.base import Part
from simtip.spectra import MetalName

Alpha = Annotated[FiniteFloat, Field(ge=0.01, le=1)]


class NeedleMaterial(Part):
    """A rough metal: GGX microfacets over measured n and k."""

    metal: Annotated[
        MetalName,
        Field(
            description=(
                "Optical constants. titanium: Johnson and Christy 1974; other sets differ, from "
                "0.40 to 0.60 in reflectance: see docs/light.md."
            )
        ),
    ] = "titanium"
    roughness: Annotated[Alpha, Field(description="GGX alpha, across the axis if brushed.")] = 0.2
    roughness_along: Annotated[
        Alpha | None,
        Field(
            description=(
                "GGX alpha along the axis; null: as across. Brushing along the axis makes it the "
                "smaller one."
            )
        ),
    ] = None
    oxide_nm: Annotated[
        FiniteFloat,
        Field(ge=0, le=500, description="Thickness of a TiO2 film that tints the metal, nm."),
    ] = 0.0
