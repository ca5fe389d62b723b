"""A scene's own camera on the EMVA 1288 bench: simulated frames in, measured parameters out.

Beside `trial`, the only place where simulation and measurement meet: the frames come from
`simtip.sensor`, the parameters from `simtip.emva`, which knows nothing of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from simtip.emva import CameraCharacteristics, measure_camera, plan_measurement
from simtip.errors import InputError
from simtip.seeding import stream
from simtip.sensor import dark_factor, expose, fixed_pattern, gains
from simtip.sensor import photons as photons_of
from simtip.spec import CameraSpec, SceneSpec, SensorSpec

Progress = Callable[[float], None]

SIDE_PX = 256
"""Side of the square of the sensor that is read out: 65,536 pixels."""

CHANNEL = 1
"""Green."""

PLANNING, PLANNING_FRAMES = 0.1, 100
"""Part of the progress that planning counts for, and about how many frames it takes."""

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
    to_top = (2**sensor.bit_depth - 1 - sensor.black_level_dn) / float(gains(sensor)[CHANNEL])
    well = min(sensor.full_well_e, to_top) if on.full_well else to_top
    growth = dark_factor(sensor.temperature_c, sensor.dark_reference_c, sensor.dark_doubling_k)
    return {
        "K_dn_per_e": float(gains(sensor)[CHANNEL]),
        "sigma_d_e": sensor.read_noise_e * (sensor.noise and on.read_noise),
        "dark_current_e_per_s": sensor.dark_current_e_per_s * growth * on.dark_current,
        "full_well_e": well,
        "prnu_percent": sensor.prnu_percent * on.prnu,
        "dsnu_e": sensor.dsnu_e * on.dsnu,
        "snr_max": math.sqrt(well),
    }


def measure_scene_camera(
    spec: SceneSpec,
    side: Literal["left", "right"] = "left",
    *,
    seed: int | None = None,
    progress: Progress | None = None,
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
    progress
        Called with the fraction of the frames taken, 0 to 1.

    Raises
    ------
    InputError
        The camera cannot be measured so: without noise, without green light, or with a gamma.
    """
    _require_measurable(spec.sensor)
    # One channel of a bare sensor: colours not mixed; single defects are not its parameters.
    effects = spec.sensor.effects.model_copy(update={"defects": False})
    sensor = spec.sensor.model_copy(update={"mosaic": None, "effects": effects})
    camera = _middle(spec.rig.left if side == "left" else spec.rig.right)
    pattern = fixed_pattern(sensor, camera, side)
    geometry = camera.camera()
    shape = (geometry.height, geometry.width, 3)
    rng = stream(spec.seed if seed is None else seed, side, "bench")
    count_frame = _Counter(progress or (lambda _: None))

    def capture(photons: float, exposure_s: float, count: int) -> Iterator[NDArray[Any]]:
        timed = sensor.model_copy(update={"exposure_s": exposure_s})
        per_irradiance = photons_of(np.ones(3), sensor.pixel_um, exposure_s, sensor.wavelength_nm)
        light = np.broadcast_to((photons / per_irradiance).astype(np.float32), shape)
        for _ in range(count):
            count_frame()
            yield expose(light, timed, camera=pattern, rng=rng)[..., CHANNEL]

    plan = plan_measurement(capture, bit_depth=sensor.bit_depth, exposure_s=EXPOSURE_S)
    count_frame.expect(plan.total_frames)
    return BenchResult(configured(sensor), measure_camera(capture, plan))


class _Counter:
    """Counts frames: up to a tenth while it is not known how many there will be."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._taken, self._total = progress, 0, 0

    def expect(self, frames: int) -> None:
        """Start anew, with that many frames to come."""
        self._taken, self._total = 0, frames

    def __call__(self) -> None:
        self._taken += 1
        if self._total:
            self._progress(PLANNING + (1 - PLANNING) * min(self._taken / self._total, 1))
        else:
            self._progress(PLANNING * min(self._taken / PLANNING_FRAMES, 1))


def _require_measurable(sensor: SensorSpec) -> None:
    """Refuse what leaves nothing to measure, naming the field."""
    if sensor.gamma != 1:
        raise InputError(
            f"{sensor.gamma:g}: EMVA 1288 measures linear cameras",
            field="sensor.gamma",
            remedy="set it to 1 for the measurement",
        )
    if not sensor.noise:
        raise InputError(
            "false: EMVA 1288 finds the gain from the noise",
            field="sensor.noise",
            remedy="set it to true for the measurement"
            + (" (the preset ideal has none)" if sensor.preset == "ideal" else ""),
        )
    if sensor.quantum_efficiency[CHANNEL] == 0:
        raise InputError(
            "0: the green channel, which is measured, sees no light",
            field=f"sensor.quantum_efficiency[{CHANNEL}]",
            remedy="give above 0 and at most 1",
        )


def _middle(camera: CameraSpec) -> CameraSpec:
    width, height = min(camera.width, SIDE_PX), min(camera.height, SIDE_PX)
    corner = (camera.width - width) // 2, (camera.height - height) // 2
    return camera.model_copy(update={"roi": (*corner, width, height)})
