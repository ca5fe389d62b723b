"""What does it say where there is no tip to see: the right reason, with its numbers?"""

import cv2
import numpy as np
import pytest
from drawn_needles import Drawn, photograph

from simtip.detect import TipStatus
from simtip.detect.subpixel import detect

SHAFT = Drawn()


def says(image):
    observation = detect(image)
    assert not observation.ok
    return observation.status, observation.reason


@pytest.mark.parametrize("level", [0, 128, 255])
def test_a_blank_picture_shows_no_edges(level):
    status, reason = says(np.full((120, 160), level, np.uint8))
    assert status == TipStatus.NOT_FOUND
    assert reason == "no two parallel edges of something dark, 6 to 80 px apart, were found"


def test_a_needle_with_both_ends_outside_has_no_tip_in_the_picture():
    image = photograph(SHAFT.light()[:130], 1)
    status, reason = says(image)
    assert status == TipStatus.TOUCHES_BORDER
    assert "both ends" in reason


@pytest.mark.slow
def test_an_end_that_is_no_tip_is_refused():
    """A blot on the tip: the fit that is best is far from good, and pixels off."""
    light = SHAFT.light()
    u, v = (round(x) for x in SHAFT.tip_px)
    cv2.circle(light, (u + 5, v - 12), 14, 60.0, -1)
    status, reason = says(photograph(light, 1))
    assert status == TipStatus.NOT_FOUND
    assert "no tip that is known" in reason or "seen to end" in reason


@pytest.mark.slow
def test_a_tip_is_never_found_outside_the_picture():
    """A rod beside the needle, which leaves the picture, once led there."""
    drawn = Drawn(degrees=6.0, tip_px=(160.0, 200.0), shape=(320, 320))
    rod = drawn.but(tip_px=(188.0, 1000.0), width_px=14.0)
    light = np.minimum(drawn.light(), rod.light())
    for seed in range(3):
        found = detect(photograph(light, seed))
        assert not found.ok or (found.tip_px < 320).all()


def test_a_shaft_too_short_is_refused_with_its_rows():
    # 40 rows of point, and 20 of shaft
    image = photograph(SHAFT.light()[130:], 1)[40:]
    status, reason = says(image)
    assert status == TipStatus.NOT_FOUND
    assert "28" in reason or "parallel" in reason or "long enough" in reason
