"""What does it say where there is no tip to see: the right reason, with its numbers?"""

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
    assert reason == "no two parallel edges 6 to 80 px apart were found"


def test_a_needle_with_both_ends_outside_has_no_tip_in_the_picture():
    image = photograph(SHAFT.light()[:130], 1)
    status, reason = says(image)
    assert status == TipStatus.TOUCHES_BORDER
    assert "both ends" in reason


def test_a_shaft_too_short_is_refused_with_its_rows():
    # 40 rows of point, and 20 of shaft
    image = photograph(SHAFT.light()[130:], 1)[40:]
    status, reason = says(image)
    assert status == TipStatus.NOT_FOUND
    assert "28" in reason or "parallel" in reason or "long enough" in reason
