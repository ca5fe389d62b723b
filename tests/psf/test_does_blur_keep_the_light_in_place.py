"""Does blur lose no light, shift nothing, stay positive, and treat borders and channels right?"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from simtip.psf import Psf, blur

WAVELENGTHS = (600.0, 540.0, 460.0)
PAPER = Psf(1.4, WAVELENGTHS, 3.2, 2.0)
PSFS = [
    pytest.param(PAPER, id="both"),
    pytest.param(Psf(1.4, WAVELENGTHS, 3.2), id="diffraction"),
    pytest.param(Psf(1.4, WAVELENGTHS, 3.2, 1.0, diffraction=False), id="gaussian"),
    pytest.param(Psf(8, WAVELENGTHS, 3.2, 3.0), id="wide"),
]


def random_image(height=40, width=56, dtype=np.float32):
    rng = np.random.default_rng(7)
    return rng.gamma(0.3, size=(height, width, 3)).astype(dtype)  # dark, with bright points


def centroid_shift(blurred, at):
    """How far the centre of all light is from (u, v), px, largest over channels and axes."""
    rows, columns, _ = np.indices(blurred.shape)
    light = blurred.astype(np.float64)
    total = light.sum(axis=(0, 1))
    u, v = ((light * place).sum(axis=(0, 1)) / total for place in (columns, rows))
    return max(np.abs(u - at[0]).max(), np.abs(v - at[1]).max())


def point(u, v, size=201):
    image = np.zeros((size, size + 8, 3), np.float32)
    image[v, u] = 1000
    return image


@pytest.mark.parametrize("psf", PSFS)
def test_a_point_in_the_frame_keeps_its_energy_and_place(psf):
    blurred = blur(point(98, 103), psf)
    np.testing.assert_allclose(blurred.sum(axis=(0, 1), dtype=np.float64), 1000, rtol=1e-6)
    assert centroid_shift(blurred, (98, 103)) < 1e-4
    assert blurred.max() < 1000


@pytest.mark.parametrize("psf", PSFS)
def test_energy_is_kept_also_at_the_border(psf):
    image = random_image()
    image[0, 0] = image[-1, 20] = 500
    before, after = (x.sum(axis=(0, 1), dtype=np.float64) for x in (image, blur(image, psf)))
    np.testing.assert_allclose(after, before, rtol=1e-6)


def test_a_kernel_half_a_pixel_off_is_noticed():
    """The planted fault: each pixel averaged with the one to its left."""
    image = point(98, 103)
    image[..., 0] = (image[..., 0] + np.roll(image[..., 0], -1, axis=1)) / 2
    assert centroid_shift(blur(image, PAPER), (98, 103)) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("psf", PSFS)
@pytest.mark.parametrize("shape", [(1, 1), (3, 2), (30, 41)])
def test_a_constant_stays_constant(psf, shape):
    flat = np.broadcast_to(np.float32([3.0, 0.7, 1e-4]), (*shape, 3))
    np.testing.assert_allclose(blur(flat, psf), flat, rtol=1e-6)


@pytest.mark.parametrize("psf", PSFS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_is_the_kernel_with_a_mirrored_border(psf, dtype):
    """Oracle: scipy's convolution with the whole kernel; its "reflect" repeats the border pixel."""
    image = random_image(dtype=dtype)
    blurred = blur(image, psf)
    assert blurred.dtype == dtype
    for c in range(3):
        expected = ndimage.convolve(image[..., c].astype(float), psf.kernel(c), mode="reflect")
        # Two passes mirror each on their own, which is the same for symmetric kernels.
        np.testing.assert_allclose(blurred[..., c], expected, rtol=0, atol=2e-6 * image.max())


@pytest.mark.parametrize("psf", PSFS)
def test_nothing_falls_below_zero_beside_a_bright_point(psf):
    for image in (point(98, 103) * 1e4, random_image()):
        assert blur(image, psf).min() >= 0


@pytest.mark.parametrize("psf", PSFS)
def test_channels_do_not_mix_and_each_has_its_wavelength(psf):
    image = random_image()
    whole = blur(image, psf)
    for c in range(3):
        alone = np.zeros_like(image)
        alone[..., c] = image[..., c]
        blurred = blur(alone, psf)
        np.testing.assert_array_equal(blurred[..., c], whole[..., c])
        assert not np.delete(blurred, c, axis=2).any()
    if psf.diffraction:
        peak = blur(point(98, 103), psf)[103, 98]
        assert peak[0] < peak[1] < peak[2]  # red spreads most


@settings(derandomize=True, deadline=None, max_examples=20)
@given(a=st.floats(0, 100), b=st.floats(0, 100))
def test_it_is_linear(a, b):
    first, second = random_image(), random_image()[::-1].copy()
    mixed = blur((a * first + b * second).astype(np.float32), PAPER)
    expected = a * blur(first, PAPER) + b * blur(second, PAPER)
    np.testing.assert_allclose(mixed, expected, rtol=0, atol=1e-6 * max(expected.max(), 1e-6))


def test_turning_the_image_turns_the_result():
    image = random_image()
    for turn in (lambda x: x[::-1], lambda x: x[:, ::-1], lambda x: x.transpose(1, 0, 2)):
        np.testing.assert_allclose(
            blur(turn(image), PAPER), turn(blur(image, PAPER)), rtol=0, atol=2e-6 * image.max()
        )


def test_without_any_part_it_is_a_copy():
    image = random_image()
    psf = Psf(1.4, WAVELENGTHS, 3.2, 0.0, diffraction=False)
    same = blur(image, psf)
    np.testing.assert_array_equal(same, image)
    assert not np.shares_memory(same, image)
    np.testing.assert_array_equal(psf.kernel(0), [[1.0]])


def test_the_input_is_left_alone():
    image = random_image()
    before = image.copy()
    blur(image, PAPER)
    np.testing.assert_array_equal(image, before)
