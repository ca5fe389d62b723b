"""How long the sensor takes for a full-size image, against the random numbers alone.

The measure is the time NumPy takes to fill two single-precision normal arrays per channel, about
the least that shot and read noise can cost. All effects are on; the fixed pattern is made once.
One thread. Prints one JSON object.

    python benchmarks/bench_sensor.py [--quick]
"""

from __future__ import annotations

import numpy as np
from environment import best_s, parser, report

from simtip.seeding import stream
from simtip.sensor import UNIFORM, expose, fixed_pattern, responsivity
from simtip.spec import CameraSpec, SensorSpec

LEVELS_E = {"bright": (7000.0, 7000.0), "dark": (8.0, 8.0), "half_dark": (2.0, 62.0)}
"""Mean electrons at the left and the right end of a ramp. The last is half below 32 e-."""
TARGET_RATIO = 3.0
SENSOR = {
    "exposure_s": 0.04,
    "prnu_percent": 1.0,
    "dsnu_e": 3.0,
    "dark_current_e_per_s": 20.0,
    "hot_fraction": 1e-4,
    "dead_fraction": 1e-4,
    "black_level_dn": 4.0,
}


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    height, width, repeats = (64, 96, 1) if quick else (1436, 2048, 7)

    rng = stream(1, "benchmark")
    spec = SensorSpec.model_validate(SENSOR)
    mono = {"width": width, "height": height, "fx": 1, "fy": 1, "cx": 0, "cy": 0}
    camera = CameraSpec.model_validate(mono)
    quiet = spec.model_copy(update={"noise": False})
    plane = np.empty((height, width), dtype=np.float32)
    ones = np.ones((height, width, 3)) / responsivity(spec)
    light = {
        name: (np.linspace(*ends, width)[None, :, None] * ones).astype(np.float32)
        for name, ends in LEVELS_E.items()
    }

    def fill() -> None:
        for _ in range(6):
            rng.standard_normal(dtype=np.float32, out=plane)

    pattern_s = best_s(lambda: fixed_pattern(spec, camera, "left"), 1)
    pattern = fixed_pattern(spec, camera, "left")
    fills_s = best_s(fill, repeats)
    times_s = {
        name: best_s(lambda light=light: expose(light, spec, camera=pattern, rng=rng), repeats)
        for name, light in light.items()
    }
    times_s["noise_off"] = best_s(
        lambda: expose(light["bright"], quiet, camera=UNIFORM, rng=rng), repeats
    )
    report(
        "sensor",
        quick=quick,
        size_px=[width, height],
        repeats=repeats,
        mean_electrons=LEVELS_E,
        sensor=SENSOR,
        normal_fills_s=fills_s,
        fixed_pattern_s=pattern_s,
        expose_s=times_s,
        ratio_to_normal_fills={name: t / fills_s for name, t in times_s.items()},
        target_ratio=TARGET_RATIO,
    )


if __name__ == "__main__":
    main()
