"""Over a thousand frames, are mean, variance and skewness those of the exact distribution?"""

from __future__ import annotations

import numpy as np
import pytest
from emva_oracle import dn_probabilities, moments

from simtip import sensor
from simtip.seeding import stream
from simtip.spec import SensorSpec

SHAPE, FRAMES = (40, 40, 3), 1000
N = 40 * 40 * 3 * FRAMES


@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "mean_e"),
    [
        ("generic_3um2", 12.0),
        ("generic_3um2", 1500.0),
        ("generic_3um2", 14000.0),
        ("low_noise", 3.0),
        ("low_noise", 25.0),
        ("low_noise", 180.0),
    ],
)
def test_the_moments_of_a_preset_are_exact(preset, mean_e):
    """The oracle sums Poisson times normal over every DN; tolerances are 4 standard errors.

    Those come from the oracle's own moments: of the mean sqrt(m2 / N), of the variance
    sqrt((m4 - m2^2) / N), of the third moment sqrt((m6 - m3^2 - 6 m4 m2 + 9 m2^3) / N).
    The mean's stays below 0.01 DN, so the mean DN is unbiased to that.
    """
    spec = SensorSpec(preset=preset, exposure_s=1e-3)
    dark = sensor.dark_electrons(spec)
    light = np.broadcast_to(mean_e / sensor.responsivity(spec), SHAPE).astype(np.float32)
    rng = stream(1, "thousand", preset, int(mean_e))
    counts = np.zeros(2**spec.bit_depth)
    for _ in range(FRAMES):
        image = sensor.expose(light, spec, camera=sensor.UNIFORM, rng=rng)
        counts += np.bincount(image.ravel(), minlength=counts.size)
    p = dn_probabilities(mean_e + dark, spec)
    mean, m2 = moments(p)
    away = np.arange(p.size) - mean
    m3, m4, m6 = (p @ away**k for k in (3, 4, 6))
    found = counts / counts.sum()
    assert 4 * np.sqrt(m2 / N) < 0.01
    assert found @ away == pytest.approx(0, abs=4 * np.sqrt(m2 / N))
    assert found @ away**2 == pytest.approx(m2, abs=4 * np.sqrt((m4 - m2**2) / N))
    error = np.sqrt((m6 - m3**2 - 6 * m4 * m2 + 9 * m2**3) / N)
    assert found @ away**3 == pytest.approx(m3, abs=4 * error)


def test_rounding_is_counted_once():
    """On a ramp over many DN, light read-out adds 1/12 DN^2 to the noise and no more.

    With 0.9 DN of read noise, the rounding's variance is 1/12 within 1e-6; an added quantisation
    noise would make it 1/6. Truncation would shift the mean by half a DN.
    """
    spec = SensorSpec(
        exposure_s=1e-3, read_noise_e=36, gain_dn_per_e=0.025, black_level_dn=20,
        effects={"shot_noise": False},
    )  # fmt: skip
    ramp = np.linspace(0, 8000, 400, dtype=np.float32)[None, :, None]
    light = (ramp / sensor.responsivity(spec)).astype(np.float32) * np.ones((300, 1, 1), np.float32)
    expected = sensor.expected_dn(light, spec, camera=sensor.UNIFORM)
    rng = stream(2, "ramp")
    errors = np.concatenate(
        [sensor.expose(light, spec, camera=sensor.UNIFORM, rng=rng) - expected for _ in range(5)]
    )
    variance = 0.81 + 1 / 12
    assert errors.mean() == pytest.approx(0, abs=4 * np.sqrt(variance / errors.size))
    assert errors.var() == pytest.approx(variance, rel=4 * np.sqrt(2 / errors.size))
