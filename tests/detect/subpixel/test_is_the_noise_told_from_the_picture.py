"""Is the noise that is told from a picture its noise, however the needle leans?"""

from functools import cache

import numpy as np
import pytest
from drawn_needles import Drawn, photograph

from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_noise import noise_of

ROUNDING_DN2 = 1 / 12


def told(drawn, image):
    """Give the noise's variance beside the needle and within it, as told from a picture."""
    rows = np.arange(5, 200)
    slope = np.tan(np.radians(drawn.degrees))
    axis_u = drawn.tip_px[0] - (drawn.tip_px[1] - rows[-1]) * slope
    shaft = Shaft(
        float(rows[-1]),
        1.0,
        np.array([axis_u, slope]),
        np.array([drawn.width_px / 2]),
        np.full(2, drawn.sigma_px**2),
        np.ones(2),
        np.zeros((0, 0)),
        np.inf,
    )
    noise = noise_of(image.astype(np.float32), rows, shaft)
    return np.polynomial.polynomial.polyval(np.array([drawn.ground_dn, 60.0]), noise)


light = cache(Drawn.light)


@pytest.mark.parametrize(
    "degrees",
    [0.0, *(pytest.param(d, marks=pytest.mark.slow) for d in (5.0, 15.0, 20.0, 30.0)), 44.0],
)
@pytest.mark.parametrize(
    "noise_dn",
    [pytest.param(0.7, marks=pytest.mark.slow), 1.5, pytest.param(4.0, marks=pytest.mark.slow)],
)
def test_at_any_slant(degrees, noise_dn):
    drawn = Drawn(degrees=degrees, tip_px=(300.3, 330.6), shape=(380, 420))
    image = photograph(light(drawn), 3, noise_dn=noise_dn)
    expected = noise_dn**2 + ROUNDING_DN2
    assert told(drawn, image) == pytest.approx([expected, expected], rel=0.12)


def test_it_grows_with_the_level_where_it_does():
    drawn = Drawn(tip_px=(300.3, 330.6), shape=(380, 420), width_px=40)
    light = drawn.light()
    rng = np.random.default_rng(4)
    image = np.rint(light + rng.normal(0, 1, light.shape) * np.sqrt(0.02 * light))
    beside, within = told(drawn, image)
    assert beside == pytest.approx(0.02 * drawn.ground_dn + ROUNDING_DN2, rel=0.1)
    assert within == pytest.approx(0.02 * 60 + ROUNDING_DN2, rel=0.3)


def test_it_grows_with_the_square_of_the_level_where_pixels_are_uneven():
    drawn = Drawn(tip_px=(300.3, 330.6), shape=(380, 420), width_px=40)
    light = drawn.light()
    image = np.rint(light * np.random.default_rng(5).normal(1, 0.01, light.shape))
    beside, within = told(drawn, image)
    assert beside == pytest.approx((0.01 * drawn.ground_dn) ** 2 + ROUNDING_DN2, rel=0.1)
    assert within == pytest.approx((0.01 * 60) ** 2 + ROUNDING_DN2, rel=0.35)


def test_without_noise_it_is_rounding():
    drawn = Drawn(tip_px=(300.3, 330.6), shape=(380, 420), degrees=0.0)
    assert told(drawn, np.rint(drawn.light())) == pytest.approx([ROUNDING_DN2] * 2)
