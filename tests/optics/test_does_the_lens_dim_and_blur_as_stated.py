"""Does each part of the lens do to the light what its formula says, and nothing else?"""

from __future__ import annotations

import numpy as np
import pytest

from simtip.camera import Camera
from simtip.optics import expose_lens, irradiance, magnification, relative_illumination
from simtip.spec import LensSpec, SensorSpec

K = np.array([[1000.0, 0, 600.0], [0, 1100.0, 400.0], [0, 0, 1]])
CAMERA = Camera(K, 1201, 801)
SENSOR = SensorSpec()
EVEN = np.full((801, 1201, 3), 0.02, np.float32)


def tangent(u: float, v: float) -> float:
    return float(np.hypot((u - 600) / 1000, (v - 400) / 1100))


def test_a_pinhole_gives_pi_l_over_4_n_squared():
    light = expose_lens(EVEN, CAMERA, LensSpec(f_number=2.8), SENSOR)
    np.testing.assert_allclose(light, np.pi * 0.02 / (4 * 2.8**2), rtol=1e-6)
    assert irradiance(np.float64(1.0), 1.0) == pytest.approx(np.pi / 4)


def test_a_lens_focused_near_gathers_less_by_its_magnification():
    lens = LensSpec(f_number=1.4, focal_length_mm=6, focus_mm=170)
    assert magnification(lens) == pytest.approx(6 / 164)
    far = expose_lens(EVEN, CAMERA, LensSpec(f_number=1.4), SENSOR)
    near = expose_lens(EVEN, CAMERA, lens, SENSOR)
    np.testing.assert_allclose(near / far, (1 + 6 / 164) ** -2, rtol=1e-6)


@pytest.mark.parametrize("pixel", [(600, 400), (0, 0), (1200, 800), (103, 757)])
def test_natural_vignetting_is_cos4_of_the_field_angle(pixel):
    kept = relative_illumination(CAMERA, LensSpec(cos4=True))
    angle = np.arctan(tangent(*pixel))
    assert kept[pixel[1], pixel[0]] == pytest.approx(np.cos(angle) ** 4, rel=1e-4)


def test_mechanical_vignetting_is_its_polynomial():
    kept = relative_illumination(CAMERA, LensSpec(vignetting=(-0.3, 0.1)))
    t = tangent(53, 701)
    assert kept[701, 53] == pytest.approx(1 - 0.3 * t**2 + 0.1 * t**4, rel=1e-4)


def test_vignetting_belongs_to_the_ray_not_to_the_crop():
    lens = LensSpec(cos4=True, vignetting=(-0.2,))
    whole = relative_illumination(CAMERA, lens)
    part = relative_illumination(CAMERA.cropped(303, 201, 500, 400), lens)
    np.testing.assert_allclose(part, whole[201:601, 303:803], rtol=1e-4)


def test_vignetting_follows_a_distorted_ray():
    bent = Camera(K, 1201, 801, (-0.1, 0.0, 0.0, 0.0))
    kept = relative_illumination(bent, LensSpec(cos4=True))
    x, y = bent.normalise([0.0, 0.0])
    assert kept[0, 0] == pytest.approx((1 + x**2 + y**2) ** -2, rel=1e-4)
    assert kept[0, 0] < relative_illumination(CAMERA, LensSpec(cos4=True))[0, 0]


@pytest.mark.parametrize("size", [(1201, 801), (1200, 800), (1197, 794), (9, 8), (1, 2)])
def test_no_light_is_asked_for_beyond_the_last_pixel(size):
    """A lens that ends within a pixel of the image: beyond, no ray exists."""
    corner = np.hypot((size[0] - 0.5) / 1000, (size[1] - 0.5) / 1000)
    k1 = -4 / 27 / corner**2  # the radial profile ends where it has reached the corner
    camera = Camera(np.array([[1000.0, 0, 0], [0, 1000.0, 0], [0, 0, 1]]), *size, (k1, 0, 0, 0))
    assert np.isnan(camera.normalise([size[0] + 7.0, size[1] + 7.0])).all()
    kept = relative_illumination(camera, LensSpec(cos4=True, vignetting=(-0.1,)))
    assert kept.shape == size[::-1]
    u, v = np.meshgrid(np.arange(0, size[0], 5), np.arange(0, size[1], 5))
    t2 = (camera.normalise(np.stack([u, v], axis=-1)) ** 2).sum(axis=-1)
    # Up to a few pixels from the end, where the ray runs away as a square root does.
    inner = np.hypot(u, v) < 980 * corner
    expected = (1 - 0.1 * t2) / (1 + t2) ** 2
    np.testing.assert_allclose(kept[v, u][inner], expected[inner], rtol=2e-3)
    assert ((kept > 0) & (kept <= 1)).all()


@pytest.mark.parametrize("lens", [{"diffraction": True}, {"aberration_um": 3.0}])
def test_point_spread_keeps_energy_and_place_and_an_even_image_even(lens):
    plain, spread = LensSpec(f_number=2), LensSpec(f_number=2, **lens)
    even = expose_lens(EVEN, CAMERA, spread, SENSOR)
    np.testing.assert_allclose(even, expose_lens(EVEN, CAMERA, plain, SENSOR), rtol=1e-5)
    point = np.zeros_like(EVEN)
    point[30, 50] = 1
    sharp, soft = (expose_lens(point, CAMERA, which, SENSOR) for which in (plain, spread))
    v, u = np.mgrid[:801, :1201]
    for channel in range(3):
        total = soft[..., channel].sum()
        assert total == pytest.approx(sharp[..., channel].sum(), rel=1e-6)
        assert soft[30, 50, channel] < 0.99 * sharp[30, 50, channel]
        centre = [(u * soft[..., channel]).sum() / total, (v * soft[..., channel]).sum() / total]
        np.testing.assert_allclose(centre, [50, 30], atol=1e-3)


@pytest.mark.parametrize(
    ("f_number", "too_high"), [(1.4, 0.071), (2.8, 0.125), (5.6, 0.172), (11, 0.013)]
)
def test_the_kernel_departs_from_airy_at_nyquist_as_the_docs_say(f_number, too_high):
    """Goodman 6.3: the OTF of a circular pupil, at 0.5 cycles a pixel along an axis."""
    psf = LensSpec(f_number=f_number, diffraction=True).point_spread(SENSOR)
    profile = psf.kernel(1).sum(axis=0)
    lag = np.arange(len(profile)) - len(profile) // 2
    kernel = (profile * np.cos(np.pi * lag)).sum()
    x = 0.5 / SENSOR.pixel_um * SENSOR.wavelength_nm[1] * 1e-3 * f_number
    airy = 2 / np.pi * (np.arccos(x) - x * np.sqrt(1 - x**2))
    assert kernel - airy == pytest.approx(too_high, abs=0.002)
