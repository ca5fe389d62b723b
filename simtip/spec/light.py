"""Lamps and the room."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, field_validator, model_validator

from simtip.errors import InputError
from simtip.flicker import Waveform, relative_output
from simtip.geometry import Array, unit
from simtip.spec.base import Fraction, NonNegative, Part, Rgb, Vector3, nonzero
from simtip.spectra import SpectrumName, luminous_efficacy

WHITE = (1.0, 1.0, 1.0)


class Ballast(Part):
    """What feeds a lamp: the ripple of its light."""

    kind: Annotated[
        Literal["electronic", "magnetic"],
        Field(description="Electronic: no ripple. Magnetic: ripple at twice the mains frequency."),
    ] = "electronic"
    mains_hz: Annotated[
        FiniteFloat, Field(ge=1, le=1000, description="The ripple has twice that frequency, Hz.")
    ] = 50.0
    ripple: Annotated[
        Fraction,
        Field(description="Modulation depth (max - min) / (max + min) of the light, 0 to 1."),
    ] = 0.3
    phase_deg: Annotated[
        FiniteFloat,
        Field(
            ge=-36000,
            le=36000,
            description=(
                "Of the ripple at t = 0, degrees; 0 is its peak. A mains phase counts twice: lamps "
                "on three phases have 0, 240, 120."
            ),
        ),
    ] = 0.0
    waveform: Annotated[
        Literal["cosine", "rectified_sine", "harmonics"], Field(description="Shape of the ripple.")
    ] = "cosine"
    harmonics: Annotated[
        tuple[tuple[Annotated[FiniteFloat, Field(ge=-1e3, le=1e3)], FiniteFloat], ...],
        Field(
            max_length=64,
            description=(
                "For waveform harmonics: relative amplitude and phase (degrees) of each harmonic "
                "of the ripple, the fundamental first; ripple sets the depth."
            ),
        ),
    ] = ()

    @model_validator(mode="after")
    def _harmonics_where_used(self) -> Ballast:
        if self.waveform == "harmonics" and not any(a for a, _ in self.harmonics):
            raise ValueError("waveform harmonics needs harmonics: [[amplitude, phase_deg], ..]")
        if self.waveform != "harmonics" and self.harmonics:
            raise ValueError(f"harmonics given, but the waveform is {self.waveform}")
        return self

    @model_validator(mode="after")
    def _electronic_has_no_ripple(self) -> Ballast:
        fields = type(self).model_fields
        for name in ("mains_hz", "ripple", "phase_deg", "waveform"):
            if self.kind == "electronic" and getattr(self, name) != fields[name].default:
                raise InputError(
                    "says how light ripples, and an electronic ballast's does not",
                    field=name,
                    remedy="give kind: magnetic, or leave it out",
                )
        return self

    @property
    def ripples(self) -> bool:
        """Whether the light changes in time at all."""
        return self.kind == "magnetic" and self.ripple > 0

    def relative(self, start_s: Array, exposure_s: float) -> Array:
        """Give the mean light over exposures that begin at `start_s`, 1 on average; same shape."""
        if not self.ripples:
            return np.ones(np.shape(start_s))
        shape = Waveform(self.waveform, self.harmonics)
        return relative_output(
            start_s, exposure_s, 2 * self.mains_hz, self.ripple, self.phase_deg, shape
        )


class Lamp(Part):
    """What every lamp has: a name, a power, a colour and a ballast.

    Power is said in one of three ways: `radiant_power_w`, `luminous_flux_lm`, `luminance_cd_m2`;
    the latter two need a spectrum. Colour is a `spectrum` or, without one, `rgb`.
    """

    name: Annotated[
        str,
        Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,31}$", description="Names its light group."),
    ]
    radiant_power_w: Annotated[
        NonNegative | None,
        Field(description="Rated visible radiant power of the whole lamp (380 to 780 nm), W."),
    ] = 9.6
    luminous_flux_lm: Annotated[
        NonNegative | None, Field(description="Instead: rated luminous flux, lm.")
    ] = None
    luminance_cd_m2: Annotated[
        NonNegative | None, Field(description="Instead: rated luminance, cd m^-2.")
    ] = None
    power: Annotated[NonNegative, Field(description="Dimming; 1 is the rated power.")] = 1.0
    rgb: Annotated[
        Rgb, Field(description="Each channel's share of the power, relative; without a spectrum.")
    ] = WHITE
    spectrum: Annotated[
        SpectrumName | None,
        Field(description="A CIE illuminant by name, e.g. FL2; null: rgb says the colour."),
    ] = None
    ballast: Annotated[Ballast, Field(description="Ripple of the light.")] = Ballast()

    @field_validator("rgb")
    @classmethod
    def _has_colour(cls, value: Rgb) -> Rgb:
        if not any(value):
            raise ValueError("a lamp without colour: set power to 0 to switch it off")
        return value

    @model_validator(mode="after")
    def _one_colour(self) -> Lamp:
        if self.spectrum is not None and self.rgb != WHITE:
            raise ValueError("rgb and spectrum both say the lamp's colour: give one of them")
        return self

    @model_validator(mode="after")
    def _one_power(self) -> Lamp:
        visual = [
            n for n in ("luminous_flux_lm", "luminance_cd_m2") if getattr(self, n) is not None
        ]
        if not visual:
            if self.radiant_power_w is None:
                raise ValueError(
                    "a lamp without power: give radiant_power_w, luminous_flux_lm or "
                    "luminance_cd_m2 (power: 0 switches it off)"
                )
            return self
        if "radiant_power_w" in self.model_fields_set and self.radiant_power_w is not None:
            visual.insert(0, "radiant_power_w")
        if len(visual) > 1:
            raise ValueError(f"{' and '.join(visual)} both say the lamp's power: give one of them")
        if self.spectrum is None:
            raise ValueError(f"{visual[0]} needs a spectrum: it says how bright a watt looks")
        self.__dict__["radiant_power_w"] = None
        return self

    @property
    def emitting_area_mm2(self) -> float:
        """The surface that shines, mm^2; each kind of lamp has its own."""
        raise NotImplementedError

    def outline_mm(self) -> Array:
        """Give points (n, 3), world, between which the lamp lies; each kind has its own."""
        raise NotImplementedError

    def rated_power_w(self) -> float:
        """Give the rated radiant power, W, from whichever figure the lamp has."""
        if self.radiant_power_w is not None:
            return self.radiant_power_w
        lumens = self.luminous_flux_lm
        if lumens is None:  # a matt emitter of area A and luminance L gives pi A L
            lumens = np.pi * self.emitting_area_mm2 * 1e-6 * (self.luminance_cd_m2 or 0.0)
        return lumens / luminous_efficacy(self.spectrum or "E")

    def total_radiance(self) -> float:
        """Give the radiance over all wavelengths, W m^-2 sr^-1: ``P / (pi A)``, a matt emitter."""
        area_m2 = self.emitting_area_mm2 * 1e-6
        return self.rated_power_w() * self.power / (np.pi * area_m2)

    def radiance(self) -> Array:
        """Give the lamp's radiance per channel (3,), W m^-2 sr^-1, by its `rgb`.

        A matt emitter of power P and area A has the radiance P / (pi A); each of the three
        channels carries a third of the power, weighted by `rgb`. A spectrum is not looked at: what
        it gives depends on the sensor and comes from `simtip.mix.weights`, and so does the ripple.
        """
        area_m2 = self.emitting_area_mm2 * 1e-6
        share = np.array(self.rgb) / sum(self.rgb)
        radiance: Array = self.rated_power_w() * self.power * share / (np.pi * area_m2)
        return radiance


class TubeLamp(Lamp):
    """A straight fluorescent tube: a cylinder that is equally bright all over."""

    kind: Literal["tube"] = "tube"
    centre_mm: Annotated[Vector3, Field(description="Middle of the tube, world frame, mm.")]
    direction: Annotated[Vector3, Field(description="Along the tube, any length.")] = (
        1.0,
        0.0,
        0.0,
    )
    length_mm: Annotated[
        FiniteFloat, Field(ge=0.01, le=1e6, description="Of the lit part, mm.")
    ] = 1200.0
    diameter_mm: Annotated[
        FiniteFloat, Field(ge=0.01, le=1e6, description="T5 16, T8 26, T12 38 mm.")
    ] = 26.0

    _along = field_validator("direction")(nonzero)

    @property
    def emitting_area_mm2(self) -> float:
        """The lit cylinder, without its ends, mm^2."""
        return float(np.pi * self.diameter_mm * self.length_mm)

    def outline_mm(self) -> Array:
        """Give the ends of the axis (2, 3)."""
        half = unit(np.array(self.direction)) * self.length_mm / 2
        return np.array(self.centre_mm) + np.stack([-half, half])


class AmbientSpec(Part):
    """Light that comes equally from everywhere else: the room's walls."""

    radiance_w_m2_sr: Annotated[
        Rgb, Field(description="Radiance of the surroundings per channel, W m^-2 sr^-1.")
    ] = (0.0, 0.0, 0.0)
