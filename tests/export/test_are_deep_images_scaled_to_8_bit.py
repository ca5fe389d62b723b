"""Images above 8 bit for formats of 8: black stays black, white white, all else nearest."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from simtip.export.eight_bit import eight_bit


@pytest.mark.parametrize("depth", [10, 12, 14, 16])
def test_every_code_goes_to_the_nearest_level(depth):
    white = 2**depth - 1
    codes = np.arange(white + 1, dtype=np.uint16)
    made = eight_bit(codes.reshape(1, -1), depth).ravel()
    assert made.dtype == np.uint8
    assert (made[0], made[-1]) == (0, 255)
    some = range(0, white + 1, max(1, white // 3000))
    off = [abs(Fraction(int(codes[k]) * 255, white) - int(made[k])) for k in some]
    assert max(off) <= Fraction(1, 2)
    # As many codes to each level, but for the two ends.
    counts = np.bincount(made)
    assert np.ptp(counts[1:-1]) <= 1
    assert abs(counts[0] - counts[-1]) <= 1


def test_images_of_8_bit_stay_as_they_are():
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert eight_bit(image, 8) is image
