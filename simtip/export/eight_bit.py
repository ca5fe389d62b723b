"""Images as formats for 8 bit take them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simtip.sensor import Image


def eight_bit(image: Image, bit_depth: int) -> NDArray[np.uint8]:
    """Give an image of 8 bit unchanged, of more scaled so that white stays white and rounded."""
    if image.dtype == np.uint8:
        return np.asarray(image, np.uint8)
    white = 2**bit_depth - 1
    return np.asarray(np.rint(image * (255.0 / white)), np.uint8)
