"""Is a needle found before what is no even ground: grain, print, things out of focus?"""

import cv2
import numpy as np
import pytest
from drawn_needles import METAL, Drawn, bevel, off, photograph

from simtip.detect.subpixel import SubpixelParameters, detect

CONE = Drawn(ground_dn=170, degrees=12.0, shape=(320, 220))
BEVEL = bevel(2.5, 1.2, ground_dn=170, shape=(320, 220), facet_level=0.2)


def grained(drawn, rms_dn, size_px, seed):
    """Give the light with grain behind the needle: rims are told from it by their brightness."""
    light = drawn.light()
    behind = np.clip((light / drawn.ground_dn - METAL[0]) / (1 - METAL[0]), 0, 1)
    noise = np.random.default_rng(seed).normal(size=light.shape)
    grain = cv2.GaussianBlur(noise, (0, 0), size_px)
    return light + behind * grain * rms_dn / grain.std()


@pytest.mark.slow
@pytest.mark.parametrize("drawn", [CONE, BEVEL], ids=["cone", "bevel"])
@pytest.mark.parametrize(("rms_dn", "size_px"), [(15.0, 1.0), (15.0, 4.0)])
def test_before_grain(drawn, rms_dn, size_px):
    """Along the axis grain as large as the tip's own end hides where it is, to a pixel or so."""
    straight = SubpixelParameters(focal_px=2000.0, centre_px=drawn.tip_px)
    errors, claims = [], []
    for seed in range(4):
        found = detect(photograph(grained(drawn, rms_dn, size_px, seed), seed), straight)
        assert found.ok, found.reason
        errors.append(off(found, drawn))
        claims.append(np.sqrt(drawn.axis @ found.covariance_px @ drawn.axis))
    along, across = np.sqrt(np.mean(np.square(errors), axis=0))
    assert along < 1
    assert across < 0.2
    assert along < 5 * np.median(claims)
