"""How far is a blurred sharp edge from the exact one, at any phase? The table of the module."""

from __future__ import annotations

import numpy as np
import pytest
from psf_oracle import LENGTH, edge_profiles, pixel_edge

from simtip.psf import Psf, blur

PIXEL_UM = 3.2
PHASES = (np.arange(16) + 0.5) / 16 - 0.5
NEAR = slice(LENGTH // 2 - 20, LENGTH // 2 + 20)


def of_pixels(sharp, psf):
    image = np.repeat(sharp.astype(np.float32)[None, :, None], 3, axis=2)
    return blur(np.repeat(image, 3, axis=0), psf)[1, :, 1].astype(np.float64)


def blurred_edge(psf, phase):
    return of_pixels(edge_profiles(0.0, 0.0, phase)[0], psf)


def of_halved_pixels(psf, phase):
    """Blur an image with pixels of half the size, then average pairs."""
    centres = (np.arange(2 * LENGTH) + 0.5) / 2 - 0.5
    return of_pixels(pixel_edge(centres, phase, 0.5), psf).reshape(-1, 2).mean(axis=1)


def crossing(profile, level):
    """Where a rising profile, linear between pixels, first reaches a level."""
    near = profile[NEAR]
    k = np.flatnonzero((near[:-1] < level) & (near[1:] >= level))[0]
    return k + (level - near[k]) / (near[k + 1] - near[k])


def crossing_errors(psf, sigma_um, level, blurred=blurred_edge):
    unit = 0.55 * psf.f_number / PIXEL_UM if psf.diffraction else 0.0
    return np.array(
        [
            crossing(blurred(psf, e), level)
            - crossing(edge_profiles(unit, sigma_um / PIXEL_UM, e)[1], level)
            for e in PHASES
        ]
    )


def lens(sigma_um, pixel_um=PIXEL_UM, **options):
    return Psf(1.4, (550.0,) * 3, pixel_um, sigma_um, **options)


@pytest.mark.parametrize(
    ("sigma_um", "level", "mean", "largest"),
    [
        (0, 0.5, 0.0, 0.0021),
        (1, 0.5, 0.0, 0.015),
        (2, 0.5, 0.0, 0.021),
        (5, 0.5, 0.0, 0.006),
        (0, 0.25, 0.010, 0.023),
        (1, 0.25, 0.024, 0.088),
        (2, 0.25, 0.020, 0.113),
        (5, 0.25, 0.015, 0.042),
    ],
)
def test_the_table_of_the_module_holds(sigma_um, level, mean, largest):
    errors = crossing_errors(lens(sigma_um), sigma_um, level)
    assert errors.mean() == pytest.approx(mean, abs=0.001)
    assert np.abs(errors).max() == pytest.approx(largest, abs=0.001)


@pytest.mark.parametrize("sigma_um", [0, 0.5, 1, 2, 3.2, 5])
@pytest.mark.parametrize("diffraction", [True, False])
def test_half_height_is_unbiased(sigma_um, diffraction):
    psf = lens(sigma_um, diffraction=diffraction)
    assert abs(crossing_errors(psf, sigma_um, 0.5).mean()) < 0.001


@pytest.mark.parametrize("sigma_um", [0, 1, 2, 5])
def test_the_position_by_area_is_exact_at_every_phase(sigma_um):
    for phase in PHASES:
        near = slice(LENGTH // 2 - 100, LENGTH // 2 + 100)
        covered = blurred_edge(lens(sigma_um), phase)[near].sum()
        assert 99.5 - covered == pytest.approx(phase, abs=1e-4)


def test_no_blur_at_all_would_be_worse():
    def sharp(_, phase):
        return edge_profiles(0.0, 0.0, phase)[0]

    for sigma_um in (1, 2, 5):
        blurred = np.abs(crossing_errors(lens(sigma_um), sigma_um, 0.5)).max()
        assert np.abs(crossing_errors(lens(sigma_um), sigma_um, 0.5, sharp)).max() > 1.5 * blurred


def test_halved_pixels_bring_every_phase_under_five_thousandths():
    fine = lens(2, PIXEL_UM / 2)
    errors = crossing_errors(fine, 2, 0.5, of_halved_pixels)
    assert np.abs(errors).max() < 0.005
