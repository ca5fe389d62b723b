"""Is the axis told by the tip's flanks as well, where the shaft alone tells it badly?"""

from functools import cache

import numpy as np
import pytest
from drawn_needles import Drawn, photograph

from simtip.detect.subpixel.analysis import analyse
from simtip.detect.subpixel.comparison import derivative
from simtip.detect.subpixel.scenery import BLUR, LEAN

HIGH = np.full(6, np.inf)


@cache
def found(**changed):
    return analyse(photograph(Drawn(**changed).light(), 1))


@pytest.mark.parametrize("degrees", [0.0, 7.0, -30.0])
def test_the_derivative_by_the_lean_is_the_difference(degrees):
    analysis = found(degrees=degrees, tip_px=(160.3, 230.6), shape=(260, 320))
    seen, tip = analysis.scenery, analysis.tip
    change = derivative(seen, tip.family, tip.values, tip.found, HIGH)[:, LEAN]
    step = np.zeros(len(tip.values))
    step[LEAN] = 1e-3
    more, less = (
        seen.cover(seen.place(tip.family, tip.values + sign * step), tip.values[BLUR])
        for sign in (1, -1)
    )
    ground, shaft, on_tip = tip.found.levels.T * seen.precision[tip.found.near]
    whole, point = (
        ((one - other) / 2e-3)[tip.found.near]
        for one, other in ((more.whole, less.whole), (more.tip, less.tip))
    )
    expected = whole * (shaft - ground) + point * (on_tip - shaft)
    assert np.linalg.norm(change - expected) < 0.15 * np.linalg.norm(expected)


@pytest.mark.slow
def test_of_a_sharp_upright_needle_each_edge_of_which_lies_in_one_column():
    """That column is as dark as both the edge's place and the rim's brightness make it."""
    for u in (120.0, 120.35, 120.5, 120.8):
        drawn = Drawn(degrees=0.0, sigma_px=0.0, tip_px=(u, 350.6), shape=(420, 240))
        light = drawn.light()
        seen = [analyse(photograph(light, seed)) for seed in range(6)]
        across = np.array([one.tip_px[0] for one in seen]) - u
        assert abs(across.mean()) < 0.015
        assert across.std(ddof=1) < 0.01


@pytest.mark.slow
def test_what_part_of_the_blur_is_a_discs():
    """A disc of radius r has variance r^2 / 4 along a direction."""
    drawn = Drawn(sigma_px=0.65, disc_px=2.1, tip_px=(120.3, 350.6), shape=(420, 240))
    light = drawn.light()
    shares = [analyse(photograph(light, seed)).shaft.disc_share for seed in range(4)]
    assert shares == pytest.approx([2.1**2 / 4 / (2.1**2 / 4 + 0.65**2)] * 4, abs=0.06)
