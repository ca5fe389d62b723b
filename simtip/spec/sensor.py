"""The sensor, in EMVA 1288 symbols."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from simtip.presets import PRESETS, PresetName
from simtip.spec.base import Fraction, Part, Positive

Electrons = Annotated[FiniteFloat, Field(ge=0, le=1e6)]
Celsius = Annotated[FiniteFloat, Field(ge=-273.15, le=200)]
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
            gt=0,
            description="Auto-exposure: the gray level, DN, that the background is to have.",
        ),
    ] = None
    wavelength_nm: Annotated[
        tuple[Positive, Positive, Positive], Field(description="Effective wavelength, nm, r g b.")
    ] = (600.0, 540.0, 460.0)
    quantum_efficiency: Annotated[
        tuple[Fraction, Fraction, Fraction], Field(description="Electrons per photon, r g b.")
    ] = (0.5, 0.5, 0.5)
    full_well_e: Annotated[
        FiniteFloat, Field(ge=1, le=1e9, description="Electrons a pixel holds before it clips.")
    ] = 10000.0
    read_noise_e: Annotated[
        Electrons, Field(description="Temporal dark noise sigma_d without exposure, e- RMS.")
    ] = 5.0
    gain_dn_per_e: Annotated[Positive, Field(description="Overall system gain K, DN/e-.")] = 0.0255
    black_level_dn: Annotated[
        FiniteFloat, Field(ge=0, description="Added before rounding, DN; below the top code.")
    ] = 0.0
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
            raise ValueError(
                f"black_level_dn {self.black_level_dn:g} is not below {top}, "
                f"the top code of {self.bit_depth} bits"
            )
        return self
