"""How long the sensor takes for a full-size image, against the random numbers alone.

The measure is the time NumPy takes to fill two single-precision normal arrays per channel, about
the least that shot and read noise can cost. One thread. Prints one JSON object.

    python benchmarks/bench_sensor.py [--quick]
"""

from __future__ import annotations

import numpy as np
from environment import best_s, parser, report

from simtip.seeding import stream
from simtip.sensor import expose, responsivity
from simtip.spec import SensorSpec

BRIGHT_E, DARK_E = 7000.0, 8.0
TARGET_RATIO = 3.0


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    height, width, repeats = (64, 96, 1) if quick else (1436, 2048, 7)

    rng = stream(1, "benchmark")
    spec = SensorSpec(f_number=1.4, exposure_s=0.04)
    quiet = spec.model_copy(update={"noise": False})
    plane = np.empty((height, width), dtype=np.float32)
    mean_e = np.ones((height, width, 3), dtype=np.float32)
    bright, dark = (
        (mean_e * (level / responsivity(spec))).astype(np.float32) for level in (BRIGHT_E, DARK_E)
    )

    def fill() -> None:
        for _ in range(6):
            rng.standard_normal(dtype=np.float32, out=plane)

    fills_s = best_s(fill, repeats)
    times_s = {
        "bright": best_s(lambda: expose(bright, spec, rng), repeats),
        "dark": best_s(lambda: expose(dark, spec, rng), repeats),
        "noise_off": best_s(lambda: expose(bright, quiet, rng), repeats),
    }
    report(
        "sensor",
        quick=quick,
        size_px=[width, height],
        repeats=repeats,
        mean_electrons={"bright": BRIGHT_E, "dark": DARK_E},
        normal_fills_s=fills_s,
        expose_s=times_s,
        ratio_to_normal_fills={name: t / fills_s for name, t in times_s.items()},
        target_ratio_bright=TARGET_RATIO,
    )


if __name__ == "__main__":
    main()
