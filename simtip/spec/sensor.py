"""The sensor, in EMVA 1288 symbols."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from simtip.spec.base import Fraction, NonNegative, Part, Positive


class SensorSpec(Part):
    """What turns radiance into digital numbers; symbols as in EMVA 1288."""

    pixel_um: Annotated[Positive, Field(description="Pixel pitch, um; all of it collects.")] = 3.2
    f_number: Annotated[Positive, Field(description="Of the lens; sets the light, not the blur.")]
    exposure_s: Annotated[Positive, Field(le=100, description="Exposure time, s.")]
    wavelength_nm: Annotated[
        tuple[Positive, Positive, Positive], Field(description="Effective wavelength, nm, r g b.")
    ] = (600.0, 540.0, 460.0)
    quantum_efficiency: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Electrons per photon, r g b.")
    ] = (0.5, 0.5, 0.5)
    full_well_e: Annotated[
        FiniteFloat, Field(ge=1, description="Electrons a pixel holds before it clips.")
    ] = 10000.0
    read_noise_e: Annotated[
        NonNegative, Field(description="Temporal dark noise sigma_d, electrons RMS.")
    ] = 5.0
    gain_dn_per_e: Annotated[Positive, Field(description="Overall system gain K, DN/e-.")] = 0.0255
    black_level_dn: Annotated[NonNegative, Field(description="Added before rounding, DN.")] = 0.0
    bit_depth: Annotated[Literal[8], Field(description="Bits per channel.")] = 8
    noise: Annotated[bool, Field(description="Shot and read noise on or off.")] = True
