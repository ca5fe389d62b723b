"""Names of the tables that a scene can ask for."""

from __future__ import annotations

from typing import Literal

SpectrumName = Literal[
    "FL1", "FL2", "FL3", "FL4", "FL5", "FL6", "FL7", "FL8", "FL9", "FL10", "FL11", "FL12",
    "FL3.1", "FL3.2", "FL3.3", "FL3.4", "FL3.5", "FL3.6", "FL3.7", "FL3.8", "FL3.9", "FL3.10",
    "FL3.11", "FL3.12", "FL3.13", "FL3.14", "FL3.15",
    "LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2",
    "A", "D50", "D65", "E",
]  # fmt: skip
"""CIE illuminants: FL fluorescent, LED white LEDs, A a filament, D50 and D65 daylight, E equal."""

ResponseName = Literal["nikon_d5100"]
"""Relative quantum efficiency of a colour sensor's channels."""

MetalName = Literal[
    "titanium", "titanium_palm", "titanium_rakic", "titanium_werner_dft", "steel_austenitic"
]
"""Optical constants n and k; ``titanium`` is Johnson and Christy 1974."""
