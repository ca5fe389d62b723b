"""How much Monte-Carlo noise a picture may have: a part of the sensor's own.

The sensor's noise is known before a ray is traced, but for the light; so the renderer is told, for
the light it finds, how far it may be off.
"""

from __future__ import annotations

import numpy as np

from simtip.exposure import auto_expose
from simtip.optics import magnification
from simtip.render import Tolerance
from simtip.render.view import Floats
from simtip.sensor import dark_electrons
from simtip.sensor.light import responsivity
from simtip.spec import SceneSpec, SensorSpec

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
    lens_factor = max(_irradiance_per_radiance(spec, side) for side in ("left", "right"))
    asked = float(share)

    def permitted(radiance: Floats, background: Floats | None) -> Floats:
        sensor = spec.sensor
        if sensor.background_dn is not None and background is not None:
            sensor = auto_expose(background.astype(np.float64) * lens_factor, sensor)
        per_radiance = responsivity(sensor) * lens_factor
        electrons = np.maximum(radiance, 0) * per_radiance
        sd_e = np.sqrt(electrons + noise_floor_e2(sensor))
        allowed: Floats = (asked * (sd_e / per_radiance).min(axis=-1)).astype(np.float32)
        return allowed

    return permitted


def noise_floor_e2(sensor: SensorSpec) -> float:
    """Give the variance of the sensor's noise without light, e-^2: dark, read, rounding.

    Noise that is switched off counts: rendering is to be good enough for it to be switched on.
    """
    rounding = QUANTISATION / sensor.gain_dn_per_e**2
    return float(dark_electrons(sensor) + sensor.read_noise_e**2 + rounding)


def _irradiance_per_radiance(spec: SceneSpec, side: str) -> float:
    lens = getattr(spec.rig, side).lens
    working = lens.f_number * (1 + magnification(lens))
    return float(np.pi / (4 * working**2))
