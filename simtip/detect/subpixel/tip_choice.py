"""Which family a tip is of: some are tried, and the one that describes it best is taken."""

from __future__ import annotations

import numpy as np

from simtip.detect.observation import TipStatus
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.outline import FAMILIES, Family
from simtip.detect.subpixel.parameters import TipKind
from simtip.detect.subpixel.scenery import BLUR, POSE, SHARP_BLURS_PX2, Scenery
from simtip.detect.subpixel.tip import BAD_MISFIT, TipFit, fit_tip
from simtip.detect.subpixel.tip_start import (
    TWINS,
    Start,
    best_start,
    elsewhere,
    like,
    usual_values,
)
from simtip.geometry import Array

FITTING_MISFIT = 2.0
"""A tip that fits so well is taken, and only what looks nearly like it tried beside it."""

GOOD_MISFIT = 4.0

POOR_MISFIT = 12.0
"""Of a fit that others need not beat: what begins badly may end well."""

NO_SHAFT_MISFIT, NO_NEEDLE_SHARE = 40.0, 0.02
"""Of a shaft that is probably none; and of the background's level what a tip's fit then leaves."""

HOPELESS_SHARE = 0.2
"""What a fit leaves, of the background's level, of no needle whatever its shaft."""

OTHER_BLUR = 3.0
"""Deviations by which a tip's blur may be off the shaft's."""

PLAIN_MISFIT = 1.8
"""A cone that fits so well is not rounded."""

ON_AXIS = {"cone", "round"}
OFF_AXIS = 0.3
"""A tip so far from the axis, in half widths, is first taken for a bevel."""

ELSEWHERE = tuple((length, turn) for length in (0.85, 1.2) for turn in (-0.15, 0.15))
"""Where a bevel that still fits badly is begun anew: by how much its cut is longer, and turned."""

STUCK_MISFIT = 10.0
"""A bevel that fits so badly at its end may have got stuck."""

NEAR = 1.5
"""Of bad fits ended in haste, those with at most so many times the best one's cost are ended."""

TRIALS = {
    "auto": ("cone", "wedge", "bevel", "bevel_away", "round"),
    "cone": ("cone",),
    "round": ("round",),
    "wedge": ("wedge",),
    "bevel": ("bevel", "bevel_away"),
}


def order(wedge: Array, kind: TipKind) -> tuple[str, ...]:
    """Give the families to try, the likely ones first."""
    if kind == "auto" and abs(wedge[0]) > OFF_AXIS:
        return ("bevel", "bevel_away", "wedge", "cone", "round")
    return TRIALS[kind]


def best_tip(
    scenery: Scenery,
    v_end: float,
    begin: Array,
    names: tuple[str, ...],
    before: TipFit | None = None,
) -> TipFit:
    """Fit families of tips until one describes the picture well; the best is taken.

    `before` is a fit to other pixels, to start from.
    """
    best: TipFit | None = None
    tried: list[TipFit] = []
    for name in names:
        if best is not None and _needless(name, best, begin):
            continue
        family = FAMILIES[name]
        try:
            start = _start(scenery, family, v_end, begin, best or before)
            found = fit_tip(scenery, family, start, _rival(scenery, name, best), hasty=True)
        except np.linalg.LinAlgError:
            continue
        if found is None:
            continue
        tried.append(found)
        if best is None or found.better_than(best):
            best = found
    if best is None:
        raise NoNeedleError(TipStatus.NOT_FOUND, "no outline fits the needle's end")
    left = scenery.left_dn(best.residual) / scenery.level
    no_shaft = best.misfit > BAD_MISFIT and scenery.shaft.misfit > NO_SHAFT_MISFIT
    if left > HOPELESS_SHARE or (left > NO_NEEDLE_SHARE and no_shaft):
        return best  # of no needle, probably: it is not worth the time
    # None was better: the haste is over.
    best = _ended_from(scenery, best.family, _at_best_blur(scenery, best)) or best
    if best.misfit > GOOD_MISFIT:
        return _unhurried(scenery, best, tried, names)
    if best.family.name == "round" and "cone" in names:
        best = or_cone(scenery, best)
    return _undecided(scenery, best, tried)


def _at_best_blur(scenery: Scenery, fit: TipFit) -> Start:
    """Give where a fit is; in a sharp picture with the first blur that no larger one betters."""
    best = Start(fit.values, fit.found)
    if not scenery.sharp:
        return best
    for variance in SHARP_BLURS_PX2:
        if variance > best.values[BLUR]:
            values = best.values.copy()
            values[BLUR] = variance
            there = Start.at(scenery, fit.family, values)
            if not there.found.cost < best.found.cost:
                break
            best = there
    return best


def _start(
    scenery: Scenery, family: Family, v_end: float, begin: Array, close: TipFit | None
) -> Start:
    """Begin as what was fitted looks; without that, and with bevels, also as usual ones do."""
    values = [] if close is None else like(family, close.family.name, close.values)
    if close is not None and close.family is family:
        near = close.misfit < FITTING_MISFIT
    else:
        near = close is not None and close.misfit < POOR_MISFIT
    if values and (near or family.name not in TWINS):
        return best_start(scenery, family, values)
    start = best_start(scenery, family, values + usual_values(scenery, family, v_end, begin))
    if close is not None and close.misfit < POOR_MISFIT:
        return start
    return elsewhere(scenery, family, start, v_end)


def _undecided(scenery: Scenery, best: TipFit, tried: list[TipFit]) -> TipFit:
    """Let a cone's fit count beside a wedge's that is about as good, and the other way round."""
    for one in tried:
        if {one.family.name, best.family.name} == {"cone", "wedge"}:
            return best.or_nearly(_ended(scenery, one.family, one.values) or one)
    return best


def _unhurried(
    scenery: Scenery, best: TipFit, tried: list[TipFit], names: tuple[str, ...]
) -> TipFit:
    """Fit what came near the best and its twins to the end, too, and give the best of them."""
    near = best.cost * NEAR
    ahead = sorted((one for one in tried if one.family is not best.family), key=lambda x: x.cost)
    ways = [(one.family, one.values) for one in ahead if one.cost < near]
    ways += [(FAMILIES[name], start) for name in TWINS for start in _alike(name, best)]
    for family, start in ways:
        ended = _ended(scenery, family, start, best)
        if ended is not None and ended.cost < best.cost:
            best = ended
            if best.misfit < FITTING_MISFIT:
                break
    if best.misfit > STUCK_MISFIT and best.family.name in TWINS:
        best = begun_elsewhere(scenery, best)
    return or_cone(scenery, best) if "cone" in names else best


def or_cone(scenery: Scenery, tip: TipFit) -> TipFit:
    """Give a cone for a wedge or a rounded cone, if it describes the same pixels as well."""
    if tip.family.name == "cone":
        return tip
    for start in like(FAMILIES["cone"], tip.family.name, tip.values):
        cone = _ended(scenery, FAMILIES["cone"], start)
        if cone is not None and cone.better_than(tip):
            return cone
    return tip


def begun_elsewhere(scenery: Scenery, best: TipFit) -> TipFit:
    """Begin a bevel anew round about where it ended, and give the best: it may have got stuck."""
    if scenery.left_dn(best.residual) > HOPELESS_SHARE * scenery.level:
        return best
    length, azimuth = best.values[POSE:]
    for longer, turn in ELSEWHERE:
        start = best.values.copy()
        start[1:POSE] = 0.0, scenery.half_px, scenery.begun_px2, 0.0
        start[POSE:] = np.clip([longer * length, azimuth + turn], best.family.low, best.family.high)
        found = _ended(scenery, best.family, start)
        if found is not None and found.cost < best.cost:
            best = found
            if best.misfit < FITTING_MISFIT:
                break
    return best


def refitted(scenery: Scenery, fit: TipFit) -> TipFit:
    """Fit a tip's family to the end, to other pixels."""
    return _ended(scenery, fit.family, fit.values) or fit


def _ended(
    scenery: Scenery, family: Family, start: Array, rival: TipFit | None = None
) -> TipFit | None:
    try:
        return _ended_from(scenery, family, Start.at(scenery, family, start), rival)
    except np.linalg.LinAlgError:
        return None


def _ended_from(
    scenery: Scenery, family: Family, start: Start, rival: TipFit | None = None
) -> TipFit | None:
    try:
        return fit_tip(scenery, family, start, rival)
    except np.linalg.LinAlgError:
        return None


def _alike(name: str, best: TipFit) -> list[Array]:
    return [best.values] if {name, best.family.name} == set(TWINS) else []


def _rival(scenery: Scenery, name: str, best: TipFit | None) -> TipFit | None:
    """Give the fit to be beaten, if there is one; of twins both are fitted to the end.

    A blur that is not the shaft's may be another tip's shape, which begins with it badly.
    """
    if best is None:
        return None
    off_px2 = abs(best.values[BLUR] - scenery.variance_px2)
    other_blur = off_px2 > OTHER_BLUR * scenery.variance_deviation
    if best.misfit > (GOOD_MISFIT if other_blur else POOR_MISFIT):
        return None
    twins = {name, best.family.name} == set(TWINS) and best.misfit < FITTING_MISFIT
    return None if twins else best


def _needless(name: str, best: TipFit, begin: Array) -> bool:
    """Say whether a family need not be tried: what fits is unlike it, or the tip is off axis."""
    if best.misfit < FITTING_MISFIT:
        return not _kin(name, best)
    return best.misfit < POOR_MISFIT and abs(begin[0]) > OFF_AXIS and name in ON_AXIS


def _kin(name: str, best: TipFit) -> bool:
    """Say whether a family is to be tried beside one that fits: one looks like the other."""
    if name == "round":
        return best.family.name == "cone" and best.misfit > PLAIN_MISFIT
    kin = {"wedge": ("cone",), "cone": (), "bevel": ("bevel_away",), "bevel_away": ("bevel",)}
    return best.family.name in kin[name]
