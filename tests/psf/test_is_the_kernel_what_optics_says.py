"""Does the discrete kernel have the transfer function, width and energy of the optics?"""

from __future__ import annotations

import numpy as np
import pytest
from psf_oracle import airy_moments, optical_transfer, over_pixels, transfer_of
from scipy import special

from simtip.psf import Psf

GREEN = (550.0, 550.0, 550.0)
FREQUENCIES = [(0.05, 0), (0.15, 0), (0.3, 0), (0.5, 0), (0, 0.25), (0.2, 0.2), (0.35, -0.35)]


def second_moment(profile):
    lags = np.arange(len(profile)) - len(profile) // 2
    return profile @ lags**2


def sharpened(u, v, by):
    """What taking `by` px^2 from the second moment does to a transfer function."""
    return 1 + by * (2 - np.cos(2 * np.pi * u) - np.cos(2 * np.pi * v))


def compared(kernel, psf):
    """Frequency, transfer function, and the closed-form OTF through the definition of a weight."""
    unit = psf.airy_unit_px(0)
    own, rounded = airy_moments(unit, psf.airy_radius_px(0))
    for u, v in FREQUENCIES:
        expected = over_pixels(u, v, unit, 0.0) * sharpened(u, v, rounded - own)
        yield np.hypot(u, v), transfer_of(kernel, u, v), expected


@pytest.mark.parametrize("f_number", [pytest.param(1.4, marks=pytest.mark.slow), 2.0, 4.0])
@pytest.mark.parametrize("energy", [0.98, pytest.param(0.995, marks=pytest.mark.slow)])
def test_diffraction_has_the_closed_transfer_function_but_for_the_veil(f_number, energy):
    psf = Psf(f_number, GREEN, 3.2, encircled_energy=energy)
    for f, found, expected in compared(psf.kernel(0), psf):
        assert abs(found.imag) < 1e-12
        # The light cut off has low frequencies only; the rest is scaled up by its share.
        assert -1e-4 < found.real - expected < expected * (1 / energy - 1) + 2.5e-3
        if f >= 0.2:
            assert found.real == pytest.approx(expected / energy, abs=1.5e-3)


def test_sampling_the_pattern_at_pixel_centres_would_fail_that():
    psf = Psf(1.4, GREEN, 3.2)
    lags = np.arange(-3, 4)
    v = np.pi / psf.airy_unit_px(0) * np.hypot(*np.meshgrid(lags, lags)) + 1e-9
    sampled = (special.j1(v) / v) ** 2
    off = [found.real - w / 0.98 for _, found, w in compared(sampled / sampled.sum(), psf)]
    assert max(off) > 0.05


@pytest.mark.parametrize("sigma_um", [0.0, pytest.param(0.4, marks=pytest.mark.slow)])
def test_on_fine_pixels_the_transfer_function_is_that_of_the_optics_alone(sigma_um):
    pixel_um = 0.154
    psf = Psf(1.4, GREEN, pixel_um, sigma_um, encircled_energy=0.99)
    kernel = psf.kernel(0)
    for f in (0.01, 0.03, 0.06, 0.1, 0.15, 0.19):  # the cut-off is at 1 / 5 cycle per px
        for u, v in ((f, 0), (f * np.sqrt(0.5), f * np.sqrt(0.5))):
            expected = optical_transfer(f, 5.0, sigma_um / pixel_um)
            assert abs(transfer_of(kernel, u, v) - expected) < 0.011


@pytest.mark.parametrize("sigma_px", [0.05, 0.2, 1.0, 2.5])
def test_the_gaussian_has_the_transfer_function_of_its_definition(sigma_px):
    psf = Psf(1.4, GREEN, 1.0, sigma_px, diffraction=False)
    lags = np.arange(-20, 21)
    area = special.ndtr((lags + 0.5) / sigma_px) - special.ndtr((lags - 0.5) / sigma_px)
    by = area @ lags**2 - sigma_px**2
    for u in (0.1, 0.25, 0.5):
        k = np.arange(-60, 61)
        # Many aliases: a narrow Gaussian's spectrum is wide, and sinc falls slowly.
        aliased = (optical_transfer(u + k, 0.0, sigma_px) * np.sinc(u + k)).sum()
        got = transfer_of(psf.kernel(0), u, 0).real
        # Wide ones lose far weights under 1e-4 that fell below zero.
        within = 2e-5 if sigma_px < 0.5 else 2e-4
        assert got == pytest.approx(aliased * sharpened(u, 0, by), abs=within)


@pytest.mark.parametrize("sigma_px", [1e-3, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.65, 0.8, 1, 2, 7, 25])
def test_the_gaussian_has_its_second_moment_at_any_width(sigma_px):
    psf = Psf(1.4, GREEN, 1.0, sigma_px, diffraction=False)
    assert second_moment(psf.gaussian_kernel()) == pytest.approx(sigma_px**2, rel=1e-9)
    assert second_moment(psf.kernel(0).sum(axis=1)) == pytest.approx(sigma_px**2, rel=1e-9)


def test_areas_alone_would_have_the_wrong_width():
    for sigma, factor in ((0.15, 0.05), (1.0, 1.08)):
        lags = np.arange(-8, 9)
        area = special.ndtr((lags + 0.5) / sigma) - special.ndtr((lags - 0.5) / sigma)
        assert second_moment(area) / sigma**2 == pytest.approx(factor, abs=0.02)


@pytest.mark.parametrize(
    "f_number",
    [*(pytest.param(n, marks=pytest.mark.slow) for n in (0.7, 1.4, 2.8, 5.6, 16.0)), 8.0],
)
def test_diffraction_has_the_second_moment_of_the_cut_pattern(f_number):
    psf = Psf(f_number, GREEN, 3.2)
    own, _ = airy_moments(psf.airy_unit_px(0), psf.airy_radius_px(0))
    for axis in (0, 1):
        assert second_moment(psf.kernel(0).sum(axis=axis)) == pytest.approx(own, rel=1e-3)


@pytest.mark.slow
def test_both_parts_add_their_second_moments():
    psf = Psf(1.4, (600, 540, 460), 3.2, 2.0)
    for channel in range(3):
        own, _ = airy_moments(psf.airy_unit_px(channel), psf.airy_radius_px(channel))
        found = second_moment(psf.kernel(channel).sum(axis=0))
        assert found == pytest.approx(own + (2.0 / 3.2) ** 2, rel=1e-3)


def test_the_first_dark_ring_holds_83_8_percent():
    """1.21967 lambda N: 0.939 um at f/1.4 and 0.55 um, where half of the pixel is 1.6 um."""
    psf = Psf(1.4, GREEN, 0.07)
    assert psf.airy_unit_px(0) * 0.07 == pytest.approx(0.77)
    kernel = psf.kernel(0)
    lags = np.arange(len(kernel)) - len(kernel) // 2
    inside = np.hypot(*np.meshgrid(lags, lags)) <= 1.21967 * 0.77 / 0.07
    assert kernel[inside].sum() * psf.encircled_energy == pytest.approx(0.838, abs=0.002)


@pytest.mark.parametrize("energy", [0.9, 0.98, 0.99])
def test_the_cut_holds_the_energy_it_says(energy):
    """Oracle: the pattern integrated by rings, against its closed total."""
    psf = Psf(1.4, GREEN, 3.2, encircled_energy=energy)
    v = np.linspace(1e-9, np.pi * psf.airy_radius_px(0) / psf.airy_unit_px(0), 200_001)
    assert np.trapezoid(2 * special.j1(v) ** 2 / v, v) == pytest.approx(energy, abs=1e-6)


@pytest.mark.parametrize("f_number", [0.7, 1.4, 4.0, 8.0, 16.0])
@pytest.mark.parametrize("sigma_um", [0.0, 0.3, 2.0])
def test_weights_are_symmetric_never_negative_and_sum_to_one(f_number, sigma_um):
    for channel, wavelength in enumerate((600, 540, 460)):
        psf = Psf(f_number, (600, 540, 460), 3.2, sigma_um)
        kernel = psf.kernel(channel)
        assert psf.airy_unit_px(channel) == pytest.approx(wavelength * 1e-3 * f_number / 3.2)
        assert kernel.sum() == pytest.approx(1, abs=1e-12)
        assert kernel.min() >= 0
        assert kernel.shape[0] % 2 == 1
        for same in (kernel.T, kernel[::-1], kernel[:, ::-1]):
            np.testing.assert_allclose(same, kernel, rtol=0, atol=1e-14)
        assert kernel.argmax() == kernel.size // 2
