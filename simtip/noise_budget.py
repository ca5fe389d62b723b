"""How much Monte-Carlo noise a picture may have: a part of the sensor's own.

The sensor's noise is known before a ray is traced, but for the light; so the renderer is told, for
the light it finds, how far it may be off.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from simtip.exposure import auto_expose
from simtip.geometry import Array
from simtip.mix import mix, steady_weights
from simtip.optics import magnification
from simtip.render import Tolerance, View
from simtip.render.view import Floats
from simtip.sensor import dark_electrons
from simtip.sensor.light import responsivity
from simtip.sensor.readout import gains
from simtip.spec import SceneSpec, SensorSpec

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")

QUANTISATION = 1 / 12
"""Variance of rounding, DN^2 (EMVA 1288)."""


def noise_tolerance(spec: SceneSpec) -> Tolerance | None:
    """Give what a renderer may leave of noise in a scene; None if the scene asks for samples.

    The strictest channel of the weaker camera lens counts; vignetting and blur are left out, which
    would both allow more.
    """
    share = spec.render.noise
    if share is None:
        return None
    lens_factor = max(_irradiance_per_radiance(spec, side) for side in SIDES)
    asked = float(share)
    plain = spec.sensor
    if plain.auto_white_balance:  # found only later, and differently in every scene
        plain = plain.model_copy(update={"white_balance": (1.0, 1.0, 1.0)})

    def permitted(radiance: Floats, background: Floats | None) -> Floats:
        sensor = plain
        if sensor.background_dn is not None:
            level = np.median(radiance, axis=0) if background is None else background
            sensor = auto_expose(level.astype(np.float64) * lens_factor, sensor)
        per_radiance = responsivity(sensor) * lens_factor
        electrons = np.maximum(radiance, 0) * per_radiance
        sd_e = np.sqrt(electrons + noise_floor_e2(sensor))
        allowed: Floats = (asked * (sd_e / per_radiance).min(axis=-1)).astype(np.float32)
        return allowed

    return permitted


def noise_share(spec: SceneSpec, view: View, side: Side) -> Floats:
    """Give a view's Monte-Carlo noise over its sensor's own, (H, W); NaN where it is not known.

    Lamps that ripple count with their mean over time.

    Parameters
    ----------
    spec
        The scene, its exposure settled.
    view
        Left or right.
    side
        Which of the two.
    """
    per_radiance = responsivity(spec.sensor) * _irradiance_per_radiance(spec, side)
    power = steady_weights(spec)
    electrons = mix(view.response, list(power)) * per_radiance.astype(np.float32)
    sd_e = np.sqrt(np.maximum(electrons, 0) + noise_floor_e2(spec.sensor).astype(np.float32))
    own = (sd_e / per_radiance.astype(np.float32)).min(axis=-1)
    share: Floats = view.noise.sd(power) / own
    return share


def noise_summary(spec: SceneSpec, views: tuple[View, View]) -> dict[str, Any]:
    """Say how noisy two views are, in parts of the sensor's own noise, for a manifest."""
    summary: dict[str, Any] = {"asked": spec.render.noise}
    for side, view in zip(SIDES, views, strict=True):
        share = noise_share(spec, view, side)
        needle = share[view.coverage > 0]
        samples = view.noise.samples
        most = samples >= spec.render.samples
        summary[side] = {
            "background_median": _finite(np.median(share)),
            "needle_median": _finite(np.median(needle)) if needle.size else None,
            "needle_95_percent": _finite(np.quantile(needle, 0.95)) if needle.size else None,
            "samples_mean": float(samples.mean()) if samples.size else None,
            "at_most_samples": float(most.mean()) if samples.size else None,
        }
    return summary


def _finite(value: np.floating[Any]) -> float | None:
    return float(value) if np.isfinite(value) else None


def noise_floor_e2(sensor: SensorSpec) -> Array:
    """Give the variance of the sensor's noise without light (3,), e-^2: dark, read, rounding.

    Noise that is switched off counts: rendering is to be good enough for it to be switched on.
    """
    rounding = QUANTISATION / gains(sensor) ** 2
    return np.asarray(dark_electrons(sensor) + sensor.read_noise_e**2 + rounding)


def _irradiance_per_radiance(spec: SceneSpec, side: Side) -> float:
    lens = (spec.rig.left if side == "left" else spec.rig.right).lens
    working = lens.f_number * (1 + magnification(lens))
    return float(np.pi / (4 * working**2))
