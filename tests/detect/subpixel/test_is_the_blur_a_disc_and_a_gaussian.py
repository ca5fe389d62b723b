"""Is the blur, along a direction and in a picture, a disc and a Gaussian in succession?"""

import numpy as np
import pytest

from simtip.detect.subpixel.blur import blurred, transfer, transfer_by_share

VARIANCE_PX2 = 1.3
PER_PX = 4, 2


def points(disc_share, seed=1, count=400_000):
    """Give where so many points of light land, along a direction: drawn, not worked out."""
    rng = np.random.default_rng(seed)
    radius = 2 * np.sqrt(disc_share * VARIANCE_PX2)
    in_disc = radius * np.sqrt(rng.random(count)) * np.cos(2 * np.pi * rng.random(count))
    return in_disc + rng.normal(0, np.sqrt((1 - disc_share) * VARIANCE_PX2), count)


@pytest.mark.parametrize("disc_share", [0.0, 0.5, 0.95, 1.0])
def test_what_is_left_of_a_frequency_is_the_mean_of_its_waves(disc_share):
    f = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    waves = np.cos(2 * np.pi * f * points(disc_share)[:, None]).mean(axis=0)
    assert transfer(f, VARIANCE_PX2, disc_share)[0] == pytest.approx(waves, abs=0.005)


@pytest.mark.parametrize("disc_share", [0.0, 0.5, 0.95, 1.0])
def test_its_derivative_is_the_difference(disc_share):
    f, h = np.linspace(0, 1, 50), 1e-5
    more, less = (transfer(f, VARIANCE_PX2 + d, disc_share)[0] for d in (h, -h))
    found = transfer(f, VARIANCE_PX2, disc_share)[1]
    assert found == pytest.approx((more - less) / (2 * h), abs=1e-6)


@pytest.mark.parametrize("disc_share", [0.0, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_picture_of_a_point_has_the_same_waves(disc_share, axis):
    cells = np.zeros((121, 81), np.float32)
    cells[60, 40] = 1
    spread = blurred(cells, VARIANCE_PX2, disc_share, PER_PX)
    profile = spread.sum(axis=1 - axis)
    at = (np.arange(len(profile)) - len(profile) // 2) / PER_PX[axis]
    f = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    waves = (profile[:, None] * np.cos(2 * np.pi * at[:, None] * f)).sum(axis=0)
    assert waves == pytest.approx(transfer(f, VARIANCE_PX2, disc_share)[0], abs=0.01)


@pytest.mark.parametrize("disc_share", [0.1, 0.5, 0.95])
def test_the_derivative_by_the_share_is_the_difference(disc_share):
    f, h = np.linspace(0.0, 0.6, 13), 1e-5
    shares = np.sqrt(disc_share**2 + np.array([h, -h]))
    more, less = (transfer(f, VARIANCE_PX2, share)[0] for share in shares)
    found = transfer_by_share(f, VARIANCE_PX2, disc_share)
    assert found == pytest.approx((more - less) / (2 * h), abs=1e-6)
