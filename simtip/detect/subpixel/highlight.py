"""Highlights too narrow for the model of a needle's brightness: their pixels are left out.

Polished metal mirrors a lamp as a bright line along the needle. Its pixels, which often are at full
scale, say nothing of where the needle ends, but a smooth brightness fitted to them is wrong beside
them, too.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from simtip.detect.subpixel.comparison import WITHIN
from simtip.detect.subpixel.scenery import POSE, Scenery
from simtip.detect.subpixel.tip import TipFit

BRIGHT_SHARE = 0.06
"""Of the needle's contrast, by which a highlight's pixels are brighter than was fitted."""

LEAST_ROWS, MOST_SHARE = 0.7, 0.5
"""Part of the rows with shaft that show a highlight, at least, and of the needle's pixels that may
be its: what shines at the tip alone is a facet, and that is no matter of a few pixels."""

OFF_AXIS = 0.3
"""A tip so far from the axis, in half widths, is cut, and what shines there its facet."""


def without_highlight(scenery: Scenery, fit: TipFit, contrast: float) -> Scenery | None:
    """Give the pixels without those of a highlight; None if there are no more, or too many.

    Parameters
    ----------
    scenery
        The pixels.
    fit
        A tip fitted to them.
    contrast
        Of the needle against the background, DN.
    """
    x, _ = fit.family.apex(1.0, fit.values[POSE:], scenery.tilt)
    if abs(x) > OFF_AXIS:
        return None
    cover = fit.found.cover
    within = cover.whole > WITHIN
    bright = (fit.residual > BRIGHT_SHARE * contrast) & within
    shape = scenery.window.shape
    wide = cv2.dilate(bright.reshape(shape).astype(np.uint8), np.ones((1, 3), np.uint8))
    left_out = scenery.left_out | ((wide.reshape(-1) > 0) & within)
    if (left_out == scenery.left_out).all() or left_out.sum() > MOST_SHARE * within.sum():
        return None
    on_shaft = (within & (cover.tip < 1 - WITHIN)).reshape(shape)
    shining = (left_out.reshape(shape) & on_shaft).any(axis=1)
    if shining.sum() < LEAST_ROWS * max(1, on_shaft.any(axis=1).sum()):
        return None
    return replace(scenery, left_out=left_out)
