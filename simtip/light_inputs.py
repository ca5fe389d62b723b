"""What of a scene decides its rendered light: all else can change without rendering again."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from simtip.spec import SceneSpec

MIXED = {
    "lamp": {
        "radiant_power_w",
        "luminous_flux_lm",
        "luminance_cd_m2",
        "power",
        "rgb",
        "spectrum",
        "ballast",
    },
    "lens": {"cos4", "vignetting", "diffraction", "aberration_um"},
    "render": {"noise"},
}
"""Fields of a lamp, a lens and `render` that count only after rendering."""

RENDERED_SENSOR = ("wavelength_nm", "spectral_response")
"""Of the sensor, what decides a metal's n and k per channel."""


def light_inputs(spec: SceneSpec) -> dict[str, Any]:
    """Give the part of a scene that its light groups depend on, as plain data.

    Powers, colours and ballasts of the lamps, the ambient level, the sensor but for its spectral
    response, what the lens does after the aperture, the rig that measures, and detection are not in
    it. Noise asked for
    is not either: it decides how long rendering takes, not what is rendered.
    """
    data = spec.model_dump(mode="json")
    rig = _without(data["rig"], {"measured"})
    for side in ("left", "right"):
        lens = _without(rig[side]["lens"], MIXED["lens"])
        if lens["focus_mm"] is None:  # a pinhole: its aperture only scales the light
            lens = {key: lens[key] for key in ("focus_mm", "distortion")}
        rig[side]["lens"] = lens
    return {
        "seed": data["seed"],
        "rig": rig,
        "needle": data["needle"],
        "background": data["background"],
        "clutter": data["clutter"],
        "lamps": [_without(lamp, MIXED["lamp"]) for lamp in data["lamps"]],
        "room": data["room"],
        "sensor": {key: data["sensor"][key] for key in RENDERED_SENSOR},
        "render": _without(data["render"], MIXED["render"]),
    }


def light_digest(spec: SceneSpec) -> str:
    """Give the SHA-256, in hexadecimal, of `light_inputs`."""
    text = json.dumps(light_inputs(spec), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def first_difference(one: SceneSpec, other: SceneSpec) -> str | None:
    """Name the first field, dotted, in which two scenes' light differs; None if it does not."""
    return _difference(light_inputs(one), light_inputs(other), "")


def _without(data: dict[str, Any], keys: set[str]) -> dict[str, Any]:
    return {key: value for key, value in data.items() if key not in keys}


def _difference(one: Any, other: Any, path: str) -> str | None:
    if isinstance(one, dict) and isinstance(other, dict):
        keys = [*one, *(key for key in other if key not in one)]
        for key in keys:
            inner = f"{path}.{key}" if path else key
            if key not in one or key not in other:
                return inner
            found = _difference(one[key], other[key], inner)
            if found:
                return found
        return None
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            found = _difference(a, b, f"{path}[{k}]")
            if found:
                return found
        return None
    return None if one == other else path
