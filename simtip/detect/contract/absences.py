"""Cases with no tip to find: nothing in the picture, or only dirt."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from simtip.detect.contract.case import Case, Verdict
from simtip.detect.contract.drawing import disc, line, picture
from simtip.detect.contract.needles import SHAPE
from simtip.detect.contract.probe import Probe, said_point
from simtip.detect.protocol import Image
from simtip.seeding import stream

SLIVERS = {"one pixel": (1, 1), "one row": (1, 50), "one column": (50, 1), "2 x 2": (2, 2)}


def _none_in(probe: Probe, images: Mapping[str, Image]) -> Verdict:
    """Pass if no tip is claimed in any of them."""
    for name, image in images.items():
        seen = probe.see(image)
        if seen.tip_px is not None:
            what = f"claims a tip where there is none: {said_point(seen.tip_px)} in {name}"
            return Verdict(passed=False, seen=what)
    return Verdict(passed=True, seen="no tip claimed")


def _even(level: int) -> dict[str, Image]:
    """Give pictures of one level in every form."""
    gray = np.full(SHAPE, level, np.uint8)
    return {
        "gray": gray,
        "colour": np.stack([gray] * 3, axis=-1),
        "16 bits": gray.astype(np.uint16) * np.uint16(257),
    }


def _blank(probe: Probe) -> Verdict:
    return _none_in(probe, {"a level": np.full(SHAPE, 200, np.uint8), "noise": picture(SHAPE, [])})


def _saturated(probe: Probe) -> Verdict:
    return _none_in(probe, _even(255))


def _black(probe: Probe) -> Verdict:
    return _none_in(probe, _even(0))


def _slivers(probe: Probe) -> Verdict:
    for k, shape in enumerate(SLIVERS.values()):
        probe.see(stream(k, "detector contract", "sliver").integers(0, 256, shape, np.uint8))
    return _none_in(
        probe,
        {
            f"{name} of {level}": np.full(shape, level, np.uint8)
            for name, shape in SLIVERS.items()
            for level in (0, 128, 255)
        },
    )


def _noise(probe: Probe) -> Verdict:
    shapes = [SHAPE, (33, 64, 3), (40, 31)]
    rng = stream(0, "detector contract", "noise alone")
    return _none_in(probe, {f"{shape}": rng.integers(0, 256, shape, np.uint8) for shape in shapes})


def dust() -> Image:
    """Draw grains up to 6 px in radius and scratches up to 2 px wide."""
    return _dust_drawn().copy()


@cache
def _dust_drawn() -> Image:
    rng = stream(0, "detector contract", "dust")
    grains = [disc(rng.uniform(10, 280, 2), r) for r in rng.uniform(0.5, 6, 40)]
    scratches = [
        line(rng.uniform(10, 280, 2), rng.uniform(10, 280, 2), width)
        for width in rng.uniform(0.5, 2, 5)
    ]
    return picture(SHAPE, [*grains, *scratches], name="dust")


def _dust(probe: Probe) -> Verdict:
    return _none_in(probe, {"dust": dust()})


def _things(probe: Probe) -> Verdict:
    things = {
        "a disc": [disc((150.2, 170.6), 60)],
        "a cable": [line((-50, 60), (400, 250), 24)],
    }
    return _none_in(probe, {name: picture(SHAPE, t, name=name) for name, t in things.items()})


ABSENCE_CASES = (
    Case("no tip on blank ground", _blank),
    Case("no tip in a saturated picture", _saturated),
    Case("no tip in a black picture", _black),
    Case("one pixel, one row, one column", _slivers),
    Case("no tip in noise alone", _noise, required=False),
    Case("no tip in dust and scratches", _dust, required=False),
    Case("no tip in a disc or a cable", _things, required=False),
)
