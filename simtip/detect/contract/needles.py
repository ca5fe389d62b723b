"""Cases with a needle to find: where its tip is said to be, and what must not move it."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from simtip.detect.contract.case import Case, NotApplicableError, Verdict
from simtip.detect.contract.drawing import Needle, picture
from simtip.detect.contract.probe import Probe, said_point
from simtip.detect.observation import TipObservation
from simtip.detect.protocol import Image
from simtip.geometry import Array

SHAPE = (360, 300)
NEEDLE = Needle((150.3, 300.4))
"""It hangs from the top: downwards, as the paper has it."""
PLACES = tuple(Needle((150.3 + 0.17 * k, 300.4 + 0.13 * k)) for k in range(4))

ALONG_PX, ACROSS_PX = 8.0, 2.0
"""How far off a tip may be. A threshold falls short of a conical tip by a few pixels."""
AXIS_DEGREES = 5.0
"""How far an axis may be off, if one is given."""
MOVED_PX = 0.05
"""How far a tip may miss the shift of a picture by whole pixels."""
MIRRORED_PX, MIRRORED_MEAN_PX = 1.0, 0.5
"""How far tips in a picture and its mirror image may disagree: each, since Canny breaks ties to one
side, and on the mean of several, which a constant shift does not pass."""
SAME_PX = 0.1
"""How far another form of the same picture may move the tip."""


def plain(needle: Needle = NEEDLE, shape: tuple[int, int] = SHAPE) -> Image:
    """Draw one needle on plain ground; its noise depends on its place."""
    return _drawn(needle, shape).copy()  # whoever looks at it may also change it


@lru_cache(maxsize=32)
def _drawn(needle: Needle, shape: tuple[int, int]) -> Image:
    return picture(shape, [needle.outline], name=str(needle))


def off(tip_px: Array, needle: Needle) -> tuple[float, float]:
    """Give how far a tip is off along the axis, positive if it falls short, and across, px."""
    error, axis = tip_px - np.array(needle.tip_px), needle.axis
    return float(error @ axis), float(error @ np.array([-axis[1], axis[0]]))


def is_near(seen: TipObservation, needle: Needle) -> bool:
    """Say whether a tip was found at this needle's."""
    if seen.tip_px is None:
        return False
    along, across = off(seen.tip_px, needle)
    return abs(along) <= ALONG_PX and abs(across) <= ACROSS_PX


def said(seen: TipObservation, needle: Needle) -> str:
    """Say where a tip was found from this needle's, or why none was."""
    if seen.tip_px is None:
        return f"no tip: {seen.reason}"
    along, across = off(seen.tip_px, needle)
    return f"{along:+.2f} px along, {across:+.2f} px across"


def found(probe: Probe, image: Image) -> Array:
    """Ask for a tip that the case depends on."""
    seen = probe.see(image)
    if seen.tip_px is None:
        raise NotApplicableError(f"no tip in the plain picture: {seen.reason}")
    return seen.tip_px


def _all_near(pairs: Iterable[tuple[TipObservation, Needle]]) -> Verdict:
    """Pass if all are near; show the worst of those found, or the first that was not."""
    shown = list(pairs)
    worst = max(shown, key=_badness)
    return Verdict(is_near(*worst), f"{said(*worst)} at worst of {len(shown)}")


def _badness(pair: tuple[TipObservation, Needle]) -> float:
    seen, needle = pair
    if seen.tip_px is None:
        return np.inf
    along, across = off(seen.tip_px, needle)
    return max(abs(along) / ALONG_PX, abs(across) / ACROSS_PX)


def _finds(probe: Probe) -> Verdict:
    return _all_near((probe.see(plain(needle)), needle) for needle in PLACES)


def _points_to_hub(probe: Probe) -> Verdict:
    away = []
    for needle in PLACES:
        seen = probe.see(plain(needle))
        if seen.axis_px is None:
            raise NotApplicableError("it gives no axis")
        cosine = np.clip(seen.axis_px @ needle.axis, -1, 1)
        away.append(float(np.degrees(np.arccos(cosine))))
    return Verdict(max(away) <= AXIS_DEGREES, f"{max(away):.1f} degrees away at worst")


def _finds_in_any_shape(probe: Probe) -> Verdict:
    shapes = [((640, 121), (60.3, 500.2)), ((351, 777), (600.3, 290.4)), ((333, 333), (99.0, 300))]
    needles = [(Needle(tip), shape) for shape, tip in shapes]
    return _all_near((probe.see(plain(needle, shape)), needle) for needle, shape in needles)


def _moves(probe: Probe) -> Verdict:
    height, width = SHAPE
    canvas = picture((460, 400), [Needle((200.3, 330.4)).outline], name="moved")
    corners = [(40, 20), (41, 20), (40, 21), (53, 7), (33, 31)]
    tips = [
        found(probe, canvas[v : v + height, u : u + width].copy()) + np.array([u, v])
        for u, v in corners
    ]
    worst = float(np.abs(np.array(tips) - tips[0]).max())
    return Verdict(
        worst <= MOVED_PX, "exactly" if worst == 0 else f"{worst:.3f} px astray at worst"
    )


def _mirrors(probe: Probe) -> Verdict:
    away = []
    for needle in PLACES:
        image = plain(needle)
        tip, mirrored = found(probe, image), found(probe, image[:, ::-1].copy())
        away.append([tip[0] + mirrored[0] - (SHAPE[1] - 1), tip[1] - mirrored[1]])
    worst, mean = np.abs(away).max(), np.abs(np.mean(away, axis=0)).max()
    passed = worst <= MIRRORED_PX and mean <= MIRRORED_MEAN_PX
    return Verdict(bool(passed), f"{worst:.2f} px apart at worst, {mean:.2f} px on the mean")


def _scales(probe: Probe) -> Verdict:
    image, lost = plain(), []
    for factor in (0.8, 0.9, 1.1, 1.2):
        seen = probe.see(np.clip(np.rint(image * factor), 0, 255).astype(np.uint8))
        if seen.tip_px is not None and not is_near(seen, NEEDLE):
            return Verdict(passed=False, seen=f"x{factor}: {said(seen, NEEDLE)}")
        if seen.tip_px is None:
            lost.append(f"x{factor}")
    return Verdict(passed=True, seen=f"no tip at {', '.join(lost)}" if lost else "found at all")


def _same(probe: Probe, image: Image) -> Verdict:
    """Compare with the plain picture."""
    tip = found(probe, plain())
    seen = probe.see(image)
    if seen.tip_px is None:
        return Verdict(passed=False, seen=f"no tip: {seen.reason}")
    away = float(np.abs(seen.tip_px - tip).max())
    return Verdict(away <= SAME_PX, "exactly" if away == 0 else f"{away:.3f} px away")


def _in_16_bits(probe: Probe) -> Verdict:
    return _same(probe, plain().astype(np.uint16) * np.uint16(257))


def _in_colour(probe: Probe) -> Verdict:
    return _same(probe, np.stack([plain()] * 3, axis=-1))


def _either_of_two(probe: Probe) -> Verdict:
    two = {"upper": Needle((80.3, 220.6)), "lower": Needle((210.7, 300.2))}
    seen = probe.see(picture(SHAPE, [needle.outline for needle in two.values()], name="two"))
    if seen.tip_px is None:
        return Verdict(passed=True, seen=f"no tip: {seen.reason}")
    at = [name for name, needle in two.items() if is_near(seen, needle)]
    return Verdict(bool(at), f"the {at[0]}" if at else f"neither, but {said_point(seen.tip_px)}")


def _at_any_angle(probe: Probe) -> Verdict:
    seen_at = []
    for degrees in range(-180, 180, 45):
        needle = Needle((240.3, 240.4), degrees)
        if is_near(probe.see(plain(needle, (480, 480))), needle):
            seen_at.append(degrees)
    where = f" (hub at {', '.join(f'{d:+d}' for d in seen_at)} degrees)" if len(seen_at) < 8 else ""
    return Verdict(len(seen_at) == 8, f"{len(seen_at)} of 8 directions{where}")


NEEDLE_CASES = (
    Case("finds a needle that points down", _finds),
    Case("its axis points to the hub", _points_to_hub),
    Case("in pictures of any shape", _finds_in_any_shape),
    Case("picture moved by whole pixels", _moves),
    Case("picture mirrored", _mirrors),
    Case("contrast times 0.8 to 1.2", _scales),
    Case("the same in 16 bits", _in_16_bits),
    Case("the same in colour", _in_colour),
    Case("two needles: one of them", _either_of_two),
    Case("at any angle", _at_any_angle, required=False),
)
