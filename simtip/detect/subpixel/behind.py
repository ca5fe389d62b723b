"""What lies behind a needle's tip: where that is no even ground, it counts as noise.

A tip before print, grain or other things is fitted with a plane in their place. What they are
beyond that is seen where the needle is not, and is about as much beside its edges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simtip.detect.subpixel.picture import LEAST_COVER
from simtip.detect.subpixel.scenery import Scenery
from simtip.detect.subpixel.tip import TipFit

ROUGH = 4.0
"""Times the noise's variance, beyond which the ground is uneven."""

MOST_SHARE = 0.25
"""Of the needle's contrast, what the ground may be uneven by."""


def with_clutter(scenery: Scenery, fit: TipFit, contrast: float) -> Scenery | None:
    """Give pixels with the ground's unevenness as noise; None if it is even, or hides the needle.

    Parameters
    ----------
    scenery
        The pixels.
    fit
        A tip fitted to them.
    contrast
        Of the needle against the background, DN.
    """
    whole = fit.found.cover.whole
    beside = (whole < LEAST_COVER) & ~scenery.left_out
    if not beside.any():
        return None
    noise = float(np.mean(scenery.noise[beside]))
    uneven = float(np.mean(fit.residual[beside] ** 2)) - noise
    if uneven < (ROUGH - 1) * noise or uneven > (MOST_SHARE * contrast) ** 2:
        return None
    return replace(scenery, clutter=uneven * np.clip(1 - whole, 0, 1))
