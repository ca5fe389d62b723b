"""A reading's information about its mean, against sums over all codes."""

from __future__ import annotations

import numpy as np
import pytest
from bound_scenes import changed
from oracles.exact_reading import exact_information

from simtip.bound import reading_information

CAMERA = {"gain": 0.0255, "black": 0.0, "bits": 8, "read_e": 5.0, "full_well_e": 10000.0}


def sensor_of(scene, **fields):
    return changed(scene, sensor=fields).sensor


def told(sensor, mean_e):
    return float(reading_information([mean_e] * 3, sensor)[1])


@pytest.mark.parametrize("mean_e", [500.0, 2000.0, 7000.0, 9000.0])
def test_it_is_that_of_all_its_codes(scene, mean_e):
    found = told(sensor_of(scene), mean_e)
    assert found == pytest.approx(exact_information(mean_e, **CAMERA), rel=0.005)


def test_near_the_full_well_it_fades(scene):
    """The well clips before the read noise, the range after it: taken as one, here within 10 %."""
    for mean_e in (9800.0, 9900.0, 10000.0, 10050.0):
        found = told(sensor_of(scene), mean_e)
        exact = exact_information(mean_e, **CAMERA)
        assert found == pytest.approx(exact, rel=0.12), mean_e
    assert told(sensor_of(scene), 10800.0) < 1e-6 * told(sensor_of(scene), 9000.0)


def test_light_alone_tells_one_over_its_mean(scene):
    sensor = sensor_of(scene, read_noise_e=0.0, gain_dn_per_e=1.0, bit_depth=16)
    assert told(sensor, 5000.0) == pytest.approx(1 / 5000, rel=1e-4)


def test_read_noise_alone_tells_one_over_its_square(scene):
    sensor = sensor_of(
        scene, read_noise_e=200.0, gain_dn_per_e=1.0, bit_depth=16, black_level_dn=5000.0
    )
    assert told(sensor, 1.0) == pytest.approx(1 / 200**2, rel=1e-3)


def test_gamma_only_counts_in_rounding(scene):
    plain, bent = (sensor_of(scene, gamma=g, bit_depth=16, gain_dn_per_e=6.0) for g in (1.0, 0.45))
    assert told(bent, 3000.0) == pytest.approx(told(plain, 3000.0), rel=1e-4)
    coarse, steep = (sensor_of(scene, gamma=g, gain_dn_per_e=0.005) for g in (1.0, 0.45))
    # In the shadows the curve is steeper than 1: finer codes.
    assert told(steep, 1000.0) > 1.5 * told(coarse, 1000.0)


def test_the_changing_variance_says_nearly_nothing(scene):
    """Left out: 1 / (2 var^2) over 1 / var, which the Poisson distribution does not have."""
    mean_e = 2000.0
    gaussian = told(sensor_of(scene), mean_e)
    assert 0.5 * gaussian**2 / gaussian < 3e-4
    assert np.isfinite(gaussian)
