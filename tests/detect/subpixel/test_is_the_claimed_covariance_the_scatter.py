"""Is the covariance that is claimed the scatter over fresh noise, along the axis and across it?"""

import cv2
import numpy as np
import pytest
from drawn_needles import Drawn, off, photograph

from simtip.detect.subpixel import detect
from simtip.detect.subpixel.likeness import likeness

TRIALS = 30


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width_px", "sigma_px", "degrees"),
    [
        (20.0, 0.7, 7.0),
        (14.0, 1.2, 7.0),
        (20.0, 0.7, 38.0),
    ],
)
def test_over_30_pictures(width_px, sigma_px, degrees):
    """Of 30 trials a standard deviation is known to 13 %: 0.7 to 1.4 is more than two of those."""
    drawn = Drawn(
        width_px=width_px,
        sigma_px=sigma_px,
        degrees=degrees,
        tip_px=(200.3, 230.6),
        shape=(260, 240),
    )
    light = drawn.light()
    ratio = claimed_to_scatter(drawn, [photograph(light, seed) for seed in range(TRIALS)])
    assert ratio == pytest.approx(np.full(2, 1.05), abs=0.35)


@pytest.mark.slow
def test_of_pictures_stored_with_loss():
    """Of 12 pictures a standard deviation is known to 21 %.

    Along the axis the tip is 0.09 px off, which is claimed, and scatters by 0.06.
    """
    drawn = Drawn(shape=(360, 260), tip_px=(150.3, 320.6))
    light, quality, images = drawn.light(), [cv2.IMWRITE_JPEG_QUALITY, 40], []
    for seed in range(12):
        _, coded = cv2.imencode(".jpg", photograph(light, seed), quality)
        images.append(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED))
    ratio = claimed_to_scatter(drawn, images)
    assert 0.7 < ratio[0] < 2.0
    assert 0.6 < ratio[1] < 1.6


@pytest.mark.parametrize(("side", "least", "most"), [(1, 0.7, 1.3), (2, 2.0, 4.0), (8, 12.0, 40.0)])
def test_of_squares_of_like_pixels_fewer_count(side, least, most):
    """A square of n x n alike has n^2 times the variance in sums, as far as it is looked at."""
    noise = np.random.default_rng(3).normal(size=(96 // side, 96 // side))
    assert least < likeness(np.kron(noise, np.ones((side, side)))) < most


def claimed_to_scatter(drawn, images):
    """Give claimed deviation over scatter (2,), along and across."""
    turn = np.array([drawn.axis, [-drawn.axis[1], drawn.axis[0]]])
    found = [detect(image) for image in images]
    errors = np.array([off(one, drawn) for one in found])
    claimed = np.mean([np.diag(turn @ one.covariance_px @ turn.T) for one in found], axis=0)
    return np.sqrt(claimed) / errors.std(axis=0, ddof=1)
