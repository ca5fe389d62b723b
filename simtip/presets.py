"""Sensors by name: what a scene's `sensor: {preset: NAME}` stands for.

Every preset is plain data; what a scene says beside it wins. Exposure time and seeds are the
scene's own and in no preset. Frame sizes are the rig's business: the figures in brackets only say
what the real sensor has.

Sources, and which figures are only typical
-------------------------------------------
``generic_3um2``
    The paper's cameras are MindVision U-300C: 3.2 um pixels, read out at 2048 x 1436 in 8 bit
    colour (the paper, section 2). Their maker does not publish what is inside. A CMOS sensor of
    that format (2048 x 1536, 3.2 um, 10-bit converter) with a public data sheet is the
    Micron/Aptina/onsemi MT9T001 (data sheet rev. F, 6/2010, table 1): greatest signal-to-noise
    ratio 43 dB, dynamic range 61 dB. The first makes a full well of 10^4.3 = 20,000 e-, the
    second a dark noise of 20,000 / 10^(61/20) = 18 e-. Typical, from no data sheet: quantum
    efficiency (its ratios make a white board look white), PRNU, DSNU, dark current and its
    doubling temperature, black level. The gain puts the full well just inside the 8-bit range.
``low_noise``
    Sony Pregius, second generation, 3.45 um, global shutter (IMX252: 2048 x 1536). The manual of
    the mvBlueFOX3 cameras (Matrix Vision, appendix on the IMX255, which has the same pixel) gives
    40.3 dB greatest signal-to-noise ratio, 71.3 dB dynamic range, 12-bit converter. By EMVA 1288
    the first makes a saturation capacity of 10^4.03 = 10,700 e-. The second is that over the
    absolute sensitivity threshold, 2.92 e- = sqrt(sigma_d^2 + 1 / (12 K^2) + 1/4) + 1/2, which
    leaves a dark noise of 2.24 e-. Typical: quantum efficiency, PRNU, DSNU, dark current, black
    level; doubling in 7 K lies in the range of 5 to 8 K that makers give for this family.
``ideal``
    The pixel, efficiency, gain and bit depth of ``generic_3um2`` and nothing else: no shot noise,
    no read noise, no differences between pixels, no dark current, no black level, a bottomless
    well. What is left is rounding to whole DN and the end of the range at 255. The same exposure
    gives the same gray level as ``generic_3um2``, less its black level of 4 DN.
"""

from __future__ import annotations

from typing import Any, Literal

PresetName = Literal["ideal", "generic_3um2", "low_noise"]

_GENERIC: dict[str, Any] = {
    "pixel_um": 3.2,
    "wavelength_nm": (600.0, 540.0, 460.0),
    "quantum_efficiency": (0.45, 0.50, 0.59),
    "full_well_e": 20000.0,
    "read_noise_e": 18.0,
    "gain_dn_per_e": 0.0125,
    "black_level_dn": 4.0,
    "bit_depth": 8,
    "prnu_percent": 1.0,
    "dsnu_e": 6.0,
    "dark_current_e_per_s": 25.0,
    "dark_reference_c": 25.0,
    "dark_doubling_k": 7.0,
    "temperature_c": 35.0,
}

PRESETS: dict[PresetName, dict[str, Any]] = {
    "ideal": {
        "pixel_um": 3.2,
        "wavelength_nm": (600.0, 540.0, 460.0),
        "quantum_efficiency": (0.45, 0.50, 0.59),
        "read_noise_e": 0.0,
        "gain_dn_per_e": 0.0125,
        "black_level_dn": 0.0,
        "bit_depth": 8,
        "noise": False,
        "effects": {"full_well": False},
    },
    "generic_3um2": _GENERIC,
    "low_noise": {
        "pixel_um": 3.45,
        "wavelength_nm": (600.0, 540.0, 460.0),
        "quantum_efficiency": (0.58, 0.65, 0.70),
        "full_well_e": 10700.0,
        "read_noise_e": 2.24,
        "gain_dn_per_e": 0.37,
        "black_level_dn": 60.0,
        "bit_depth": 12,
        "prnu_percent": 0.6,
        "dsnu_e": 0.6,
        "dark_current_e_per_s": 3.0,
        "dark_reference_c": 25.0,
        "dark_doubling_k": 7.0,
        "temperature_c": 45.0,
    },
}
