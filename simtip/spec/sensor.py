"""The sensor, in EMVA 1288 symbols."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from simtip.errors import InputError
from simtip.presets import PRESETS, PresetName
from simtip.spec.base import Fraction, Part, Positive
from simtip.spectra import ResponseName, peak_factor, response

Electrons = Annotated[FiniteFloat, Field(ge=0, le=1e6)]
Celsius = Annotated[FiniteFloat, Field(ge=-273.15, le=200)]
ChannelGain = Annotated[FiniteFloat, Field(ge=0.05, le=20)]
RareFraction = Annotated[FiniteFloat, Field(ge=0, le=0.1)]


class EffectsSpec(Part):
    """Switches: false leaves an effect out, whatever its figure says."""

    shot_noise: Annotated[bool, Field(description="Of light and of dark current.")] = True
    read_noise: bool = True
    prnu: bool = True
    dsnu: bool = True
    dark_current: Annotated[bool, Field(description="Hot pixels included.")] = True
    full_well: Annotated[bool, Field(description="False: a bottomless well.")] = True
    defects: Annotated[bool, Field(description="Hot and dead pixels.")] = True


class SensorSpec(Part):
    """What turns irradiance into digital numbers; symbols as in EMVA 1288."""

    preset: Annotated[
        PresetName | None,
        Field(
            description=(
                "Take what is not given here from: ideal (rounding only), generic_3um2 (like the "
                "paper's cameras), low_noise (a machine-vision camera)."
            )
        ),
    ] = None
    pixel_um: Annotated[Positive, Field(description="Pixel pitch, um; all of it collects.")] = 3.2
    exposure_s: Annotated[
        Positive, Field(le=100, description="Exposure time, s; background_dn overrides it.")
    ] = 0.05
    background_dn: Annotated[
        FiniteFloat | None,
        Field(
            description=(
                "Auto-exposure: the gray level, DN, that the backgrounds of both cameras are to "
                "have on average; above the black level, below the top code."
            ),
        ),
    ] = None
    wavelength_nm: Annotated[
        tuple[Positive, Positive, Positive], Field(description="Effective wavelength, nm, r g b.")
    ] = (600.0, 540.0, 460.0)
    quantum_efficiency: Annotated[
        tuple[Fraction, Fraction, Fraction],
        Field(description="Electrons per photon at wavelength_nm, r g b."),
    ] = (0.5, 0.5, 0.5)
    spectral_response: Annotated[
        ResponseName | None,
        Field(
            description=(
                "How quantum_efficiency runs over wavelength, for lamps with a spectrum: as in a "
                "camera measured; null: constant over the wavelengths nearest to the channel's own."
            )
        ),
    ] = None
    row_time_s: Annotated[
        FiniteFloat,
        Field(
            ge=0,
            le=1,
            description=(
                "Rolling shutter: from one row's start of exposure to the next one's, s, top to "
                "bottom, the first row of the region of interest first. 0 is a global shutter."
            ),
        ),
    ] = 0.0
    start_s: Annotated[
        FiniteFloat,
        Field(ge=-1e6, le=1e6, description="When the first row's exposure begins, s."),
    ] = 0.0
    full_well_e: Annotated[
        FiniteFloat, Field(ge=1, le=1e9, description="Electrons a pixel holds before it clips.")
    ] = 10000.0
    read_noise_e: Annotated[
        Electrons, Field(description="Temporal dark noise sigma_d without exposure, e- RMS.")
    ] = 5.0
    gain_dn_per_e: Annotated[Positive, Field(description="Overall system gain K, DN/e-.")] = 0.0255
    white_balance: Annotated[
        tuple[ChannelGain, ChannelGain, ChannelGain],
        Field(description="Gain of each channel over gain_dn_per_e, r g b."),
    ] = (1.0, 1.0, 1.0)
    auto_white_balance: Annotated[
        bool,
        Field(
            description="Set white_balance so that the background comes out gray; green keeps 1."
        ),
    ] = False
    black_level_dn: Annotated[
        FiniteFloat, Field(ge=0, description="Added before rounding, DN; below the top code.")
    ] = 0.0
    gamma: Annotated[
        FiniteFloat,
        Field(
            ge=0.1,
            le=10,
            description=(
                "Output code = top (code / top)^gamma, before rounding; 1 is linear, below 1 lifts "
                "the shadows."
            ),
        ),
    ] = 1.0
    bit_depth: Annotated[Literal[8, 10, 12, 16], Field(description="Bits per channel.")] = 8
    prnu_percent: Annotated[
        FiniteFloat, Field(ge=0, le=20, description="Standard deviation of the response, %.")
    ] = 0.0
    dsnu_e: Annotated[
        Electrons, Field(description="Standard deviation of the dark signal over pixels, e-.")
    ] = 0.0
    dark_current_e_per_s: Annotated[
        FiniteFloat, Field(ge=0, le=1e9, description="At dark_reference_c, e-/s per pixel.")
    ] = 0.0
    dark_reference_c: Annotated[Celsius, Field(description="Where it was measured, C.")] = 25.0
    dark_doubling_k: Annotated[
        FiniteFloat, Field(ge=1, le=100, description="It doubles with every so many kelvin.")
    ] = 7.0
    temperature_c: Annotated[Celsius, Field(description="Of the sensor, C.")] = 25.0
    hot_fraction: Annotated[
        RareFraction, Field(description="Share of pixels with extra dark current.")
    ] = 0.0
    hot_current_e_per_s: Annotated[
        FiniteFloat, Field(ge=0, le=1e9, description="Theirs, at dark_reference_c, e-/s.")
    ] = 10000.0
    dead_fraction: Annotated[
        RareFraction, Field(description="Share of pixels that see no light.")
    ] = 0.0
    fixed_pattern_seed: Annotated[
        int,
        Field(ge=0, lt=2**63, description="Which pair of cameras it is: decides their pixels."),
    ] = 0
    mosaic: Annotated[
        Literal["rggb"] | None,
        Field(
            description=(
                "One channel a pixel, red at the full sensor's corner, and OpenCV's bilinear "
                "demosaicing; null: every pixel has all three."
            )
        ),
    ] = None
    noise: Annotated[
        bool, Field(description="Temporal noise (shot and read) on or off, in one switch.")
    ] = True
    effects: EffectsSpec = EffectsSpec()

    @model_validator(mode="after")
    def _preset_beneath(self) -> SensorSpec:
        # Before validation would be the usual place, but strict JSON then takes no list as tuple.
        if self.preset is not None:
            preset = dict(PRESETS[self.preset])
            chosen = self.effects.model_dump(include=self.effects.model_fields_set)
            preset["effects"] = EffectsSpec(**{**preset.pop("effects", {}), **chosen})
            given = self.model_fields_set - {"effects"}
            self.__dict__.update({k: v for k, v in preset.items() if k not in given})
        return self

    @model_validator(mode="after")
    def _black_is_below_white(self) -> SensorSpec:
        top = 2**self.bit_depth - 1
        if self.black_level_dn >= top:
            raise InputError(
                f"{self.black_level_dn:g} DN is not below the top code of {self.bit_depth} bits",
                field="black_level_dn",
                remedy=f"give at least 0 and below {top}",
            )
        return self

    @model_validator(mode="after")
    def _background_is_in_range(self) -> SensorSpec:
        top = 2**self.bit_depth - 1
        black = top * (self.black_level_dn / top) ** self.gamma
        if self.background_dn is not None and not black < self.background_dn < top:
            raise InputError(
                f"{self.background_dn:g} DN is no gray level between the black level and the top "
                f"code of {self.bit_depth} bits",
                field="background_dn",
                remedy=f"give above {black:.4g} and below {top}",
            )
        return self

    @model_validator(mode="after")
    def _efficiency_is_a_fraction(self) -> SensorSpec:
        if self.spectral_response is None:
            return self
        over = peak_factor(response(self.spectral_response), self.wavelength_nm)
        for name, efficiency, nm, factor in zip(
            ("red", "green", "blue"), self.quantum_efficiency, self.wavelength_nm, over, strict=True
        ):
            if not np.isfinite(factor):
                raise ValueError(
                    f"the {name} channel of {self.spectral_response} is blind at its wavelength_nm "
                    f"of {nm:g} nm"
                )
            if efficiency * factor > 1:
                raise ValueError(
                    f"quantum_efficiency {efficiency:g} at {nm:g} nm makes the {name} channel of "
                    f"{self.spectral_response} peak at {efficiency * factor:.3g}, over 1"
                )
        return self
