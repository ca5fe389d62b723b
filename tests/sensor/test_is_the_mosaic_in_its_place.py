"""Does each pixel keep the channel that its place on the full sensor has, and nothing shift?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip import sensor
from simtip.seeding import stream
from simtip.spec import CameraSpec, SensorSpec

SPEC = SensorSpec(exposure_s=0.1, noise=False, gain_dn_per_e=0.1, bit_depth=12, mosaic="rggb")
THREE = SPEC.model_copy(update={"mosaic": None})
ORIGINS = [(0, 0), (1, 0), (0, 1), (1, 1), (6, 3)]


def camera(x, y, width=24, height=20):
    return CameraSpec(width=60, height=50, fx=1, fy=1, cx=0, cy=0, roi=(x, y, width, height))


def light(mean_e):
    return (mean_e / sensor.responsivity(SPEC)).astype(np.float32)


def channel(x, y):
    """Red, green / green, blue, written out."""
    return {(0, 0): 0, (1, 0): 1, (0, 1): 1, (1, 1): 2}[x % 2, y % 2]


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_pixel_keeps_its_own_channel(origin):
    """Noise-free random light, with fixed patterns and hot pixels: own channels are untouched."""
    spec = {"prnu_percent": 3, "dsnu_e": 50, "hot_fraction": 0.05, "black_level_dn": 100}
    with_mosaic, without = (each.model_copy(update=spec) for each in (SPEC, THREE))
    pattern = sensor.fixed_pattern(with_mosaic, camera(*origin), "left")
    some = light(np.random.default_rng(1).uniform(500, 9000, (20, 24, 3)))
    mosaic, full = (
        sensor.expose(some, each, camera=pattern, rng=stream(1)) for each in (with_mosaic, without)
    )
    for v in range(1, 19):
        for u in range(1, 23):
            own = channel(u + origin[0], v + origin[1])
            assert mosaic[v, u, own] == full[v, u, own]


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_ramp_does_not_shift(origin):
    """Bilinear interpolation is exact on a plane: less than a DN at any phase of the mosaic."""
    plane = light(2000.0 + 200 * np.arange(24)[None, :, None] + 50 * np.arange(20)[:, None, None])
    pattern = sensor.fixed_pattern(SPEC, camera(*origin), "left")
    mosaic, full = (
        sensor.expose(plane, each, camera=pattern, rng=stream(1)) for each in (SPEC, THREE)
    )
    difference = (mosaic.astype(int) - full)[2:-2, 2:-2]
    assert np.abs(difference).max() <= 1
    assert np.ptp(full) > 100


def test_colours_stay_apart():
    one = light(np.broadcast_to([8000.0, 4000.0, 1000.0], (20, 24, 3)))
    image = sensor.expose(one, SPEC, camera=sensor.UNIFORM, rng=stream(1))
    np.testing.assert_array_equal(image, np.broadcast_to([800, 400, 100], (20, 24, 3)))


def test_a_third_of_the_noise_is_drawn_and_interpolation_smooths_it():
    """A green value of a red pixel is the mean of four: a quarter of the variance."""
    noisy = SPEC.model_copy(update={"noise": True})
    some = light(np.full((200, 240, 3), 5000.0))
    image = sensor.expose(some, noisy, camera=sensor.UNIFORM, rng=stream(2)).astype(float)
    own, made = image[2:-2:2, 3:-2:2, 1], image[2:-2:2, 2:-2:2, 1]
    variance = 0.01 * (5000 + 25) + 1 / 12
    assert own.var() == pytest.approx(variance, rel=4 * np.sqrt(2 / own.size))
    # Neighbours share two of their four pixels: about half as many are independent.
    assert made.var() == pytest.approx(variance / 4 + 1 / 12, rel=6 * np.sqrt(2 / made.size))


def test_too_few_pixels_are_refused():
    with pytest.raises(ValueError, match="3 x 3"):
        sensor.expose(light(np.ones((2, 9, 3))), SPEC, camera=sensor.UNIFORM, rng=stream(1))
