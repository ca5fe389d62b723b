"""Cases about how a detector treats what it is given, whatever it finds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.detect.contract.absences import dust
from simtip.detect.contract.case import Case, Verdict
from simtip.detect.contract.needles import plain
from simtip.detect.contract.probe import Probe
from simtip.detect.observation import TipObservation
from simtip.detect.protocol import Image
from simtip.geometry import Array


def difference(a: TipObservation, b: TipObservation) -> str:
    """Name what two observations differ in, to the bit, or nothing."""
    pairs: dict[str, tuple[Array | None, Array | None]] = {
        "tip": (a.tip_px, b.tip_px),
        "axis": (a.axis_px, b.axis_px),
        "covariance": (a.covariance_px, b.covariance_px),
    }
    names = [name for name, (x, y) in pairs.items() if not _equal(x, y)]
    if (a.status, a.reason) != (b.status, b.reason):
        names.append("status or reason")
    return ", ".join(names)


def _equal(x: Array | None, y: Array | None) -> bool:
    if x is None or y is None:
        return x is y
    return np.array_equal(x, y)


def _twice(probe: Probe) -> Verdict:
    for name, image in {"a needle": plain(), "dust": dust()}.items():
        first = probe.see(image)
        probe.see(np.zeros((50, 40), np.uint8))  # what it saw in between must not matter
        if differs := difference(first, probe.see(image)):
            return Verdict(passed=False, seen=f"another {differs} the second time, on {name}")
    return Verdict(passed=True, seen="to the bit")


def _layouts() -> dict[str, Image]:
    """Give the plain picture as arrays of every layout in memory."""
    image = np.stack([plain()] * 3, axis=-1)
    frozen = image.copy()
    frozen.setflags(write=False)
    return {
        "contiguous": image,
        "read-only": frozen,
        "in Fortran's order": np.asfortranarray(image),
        "strided": np.repeat(np.repeat(image, 2, axis=0), 2, axis=1)[::2, ::2],
        "of negative strides": np.ascontiguousarray(image[::-1, ::-1])[::-1, ::-1],
    }


def _any_layout(probe: Probe) -> Verdict:
    layouts = _layouts()
    expected = probe.see(layouts["contiguous"])
    for name, image in layouts.items():
        if differs := difference(expected, probe.see(image)):
            return Verdict(passed=False, seen=f"another {differs} when the array is {name}")
    return Verdict(passed=True, seen=f"the same in {len(layouts)} layouts")


def _refuses(probe: Probe) -> Verdict:
    """Ask about arrays that are no images."""
    wrong: dict[str, NDArray[Any]] = {
        "floats": np.zeros((4, 4)),
        "two channels": np.zeros((4, 4, 2), np.uint8),
        "no pixel": np.zeros((0, 3), np.uint8),
    }
    taken = [name for name, array in wrong.items() if not probe.refuses(array)]
    text = f"takes {', '.join(taken)} for an image" if taken else "by InputError"
    return Verdict(not taken, text)


def _leaves_alone(probe: Probe) -> Verdict:
    gray = plain()
    for image in (gray, np.stack([gray] * 3, axis=-1), gray.astype(np.uint16) * np.uint16(257)):
        probe.see(image)
    changed = list(dict.fromkeys(probe.changed))
    text = f"changed one of {changed[0]}" if changed else f"none of {probe.asked} changed"
    return Verdict(not changed, text)


MANNERS_CASES = (
    Case("the same answer twice", _twice),
    Case("any layout in memory", _any_layout),
    Case("refuses what is no image", _refuses),
    Case("leaves images as they are", _leaves_alone),
)
"""The last one looks back at every image that was shown."""
