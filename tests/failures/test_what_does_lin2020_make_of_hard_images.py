"""What `lin2020` does today with every hard scene, left and right: right, wrong, or no tip and why.

An expectation is no wish: where it is a failure, a change that finds the tip has to change it here.
"""

from __future__ import annotations

import pytest
from hard_scenes import NAMES, simulated

from simtip.detect import configure
from simtip.score import pixel_error

BAND_PX = 2.0
"""Along and across: the answer is on the pixel grid, and noise moves it by a pixel or two."""

EXPECTED = {
    "absent": ((8.6, 0.4), "touches_border"),
    "bent": ((8.6, 0.4), (8.7, -0.4)),
    "blunt": ((-0.4, -0.1), (-0.3, -0.8)),
    "bright_tip": ((33.6, 6.9), (26.6, 2.7)),  # the bright cut is taken for background
    "coloured": ("no_component_large_enough", (7.7, -0.5)),  # highlights leave too little
    "dark_shadow": ((-88.4, -26.6), (-89.5, 58.6)),  # the shadow's end
    "defocus_far": ((8.6, -0.1), (9.7, 0.1)),
    "defocus_near": ((7.6, 0.4), (8.7, -0.4)),
    "dust_on_tip": ((8.6, 0.4), (8.7, -0.4)),  # the grain is cut off, with the tip before it
    "franseen": ((1.6, -6.6), (2.0, -9.7)),  # another of the crown's points
    "gradient": ("touches_border", "touches_border"),  # the board below is too dark
    "gray_board": ("no_component_large_enough",) * 2,  # the needle is brighter than the board
    "hostile": ("touches_border", (-39.9, 186.0)),  # a cable; a rod
    "lancet": ((3.6, -0.1), (4.7, -0.6)),
    "low_contrast": ("everything_darker_than_threshold",) * 2,
    "near_border": ((8.6, 0.4), (9.7, -0.4)),
    "noisy": ((8.6, 0.4), (9.7, -0.4)),
    "pointing_left": ("touches_border",) * 2,  # the lowest pixel is the shaft's, at the border
    "pointing_up": ("touches_border",) * 2,
    "rods": ("touches_border",) * 2,  # the rods'
    "saturated": ((10.6, 0.4), (11.7, -0.3)),
    "slanted": ((6.4, -0.2), (7.0, 0.9)),
    "streak": ((11.6, -0.1), (12.7, -1.3)),
    "thick": ((6.6, 0.4), (6.7, -0.5)),
    "thin": ((10.6, 0.4), (10.7, -0.4)),
    "trocar": ((2.6, -0.1), (3.7, 0.4)),
}
"""Error along and across the needle, px, of the left and the right view; or the status."""


def test_every_hard_scene_has_its_expectation():
    assert sorted(EXPECTED) == NAMES
    assert len(NAMES) >= 26


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_it_does_what_it_did(name):
    simulation = simulated(name)
    truth = simulation.truth
    detect = configure("lin2020")
    for image, view, expected in zip(
        simulation.images, (truth.left, truth.right), EXPECTED[name], strict=True
    ):
        seen = detect(image)
        error = pixel_error(seen.tip_px, view.tip_px, view.axis_px)
        if isinstance(expected, str):
            assert seen.status == expected
        else:
            assert error is not None, seen.reason
            assert [error.along_px, error.across_px] == pytest.approx(expected, abs=BAND_PX)
