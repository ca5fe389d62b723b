"""A scene's own camera on the EMVA 1288 bench: simulated frames in, measured parameters out.

Beside `trial`, the only place where simulation and measurement meet: the frames come from
`simtip.sensor`, the parameters from `simtip.emva`, which knows nothing of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from simtip.emva import CameraCharacteristics, measure_camera, plan_measurement
from simtip.seeding import stream
from simtip.sensor import dark_factor, expose, fixed_pattern
from simtip.sensor import photons as photons_of
from simtip.spec import CameraSpec, SceneSpec, SensorSpec

SIDE_PX = 256
"""Side of the square of the sensor that is read out: 65,536 pixels."""

CHANNEL = 1
"""Green."""

EXPOSURE_S = 1e-3
"""Of the photon-transfer series: short, so that dark current is small."""


@dataclass(frozen=True, eq=False)
class BenchResult:
    """What was configured and what was found, by the same names.

    Attributes
    ----------
    configured
        From the scene, at the sensor's temperature.
    recovered
        From the frames alone.
    """

    configured: dict[str, float]
    recovered: CameraCharacteristics

    def to_dict(self) -> dict[str, Any]:
        """Give plain data: the keys of ``camera --json``."""
        found = self.recovered.to_dict()
        return {
            "configured": self.configured,
            "recovered": {key: found[key] for key in self.configured},
            **{key: found[key] for key in ("ci99", "reasons", "full_well_limit", "notes")},
        }


def configured(sensor: SensorSpec) -> dict[str, float]:
    """Give the parameters that a measurement should find.

    The full well is where the signal stops, at the well or at the top code, whichever comes first.
    """
    on = sensor.effects
    to_top = (2**sensor.bit_depth - 1 - sensor.black_level_dn) / sensor.gain_dn_per_e
    well = min(sensor.full_well_e, to_top) if on.full_well else to_top
    growth = dark_factor(sensor.temperature_c, sensor.dark_reference_c, sensor.dark_doubling_k)
    return {
        "K_dn_per_e": sensor.gain_dn_per_e,
        "sigma_d_e": sensor.read_noise_e * (sensor.noise and on.read_noise),
        "dark_current_e_per_s": sensor.dark_current_e_per_s * growth * on.dark_current,
        "full_well_e": well,
        "prnu_percent": sensor.prnu_percent * on.prnu,
        "dsnu_e": sensor.dsnu_e * on.dsnu,
        "snr_max": math.sqrt(well),
    }


def measure_scene_camera(
    spec: SceneSpec, side: Literal["left", "right"] = "left", *, seed: int | None = None
) -> BenchResult:
    """Put one camera of a scene under even light and measure it.

    The middle of its sensor is read out, green channel, without lens.

    Parameters
    ----------
    spec
        The scene; its sensor and the camera's own fixed pattern.
    side
        Which camera.
    seed
        Of the temporal noise; by default the scene's own.

    Raises
    ------
    InputError
        The camera cannot be measured so, e.g. without noise.
    """
    # One channel of a bare sensor: colours not mixed; single defects are not its parameters.
    effects = spec.sensor.effects.model_copy(update={"defects": False})
    sensor = spec.sensor.model_copy(update={"mosaic": None, "effects": effects})
    camera = _middle(spec.rig.left if side == "left" else spec.rig.right)
    pattern = fixed_pattern(sensor, camera, side)
    geometry = camera.camera()
    shape = (geometry.height, geometry.width, 3)
    rng = stream(spec.seed if seed is None else seed, side, "bench")

    def capture(photons: float, exposure_s: float, count: int) -> Iterator[NDArray[Any]]:
        timed = sensor.model_copy(update={"exposure_s": exposure_s})
        per_irradiance = photons_of(np.ones(3), sensor.pixel_um, exposure_s, sensor.wavelength_nm)
        light = np.broadcast_to((photons / per_irradiance).astype(np.float32), shape)
        for _ in range(count):
            yield expose(light, timed, camera=pattern, rng=rng)[..., CHANNEL]

    plan = plan_measurement(capture, bit_depth=sensor.bit_depth, exposure_s=EXPOSURE_S)
    return BenchResult(configured(sensor), measure_camera(capture, plan))


def _middle(camera: CameraSpec) -> CameraSpec:
    width, height = min(camera.width, SIDE_PX), min(camera.height, SIDE_PX)
    corner = (camera.width - width) // 2, (camera.height - height) // 2
    return camera.model_copy(update={"roi": (*corner, width, height)})
