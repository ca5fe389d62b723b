"""All that can be found out about a needle in one picture: shaft, tip, and how well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from simtip.detect.gray import Gray
from simtip.detect.observation import TipStatus
from simtip.detect.protocol import Image
from simtip.detect.subpixel.bands import Band, find_bands
from simtip.detect.subpixel.frame import Frame
from simtip.detect.subpixel.gray import coarse_gray, mean_gray
from simtip.detect.subpixel.outline import FAMILIES
from simtip.detect.subpixel.parameters import DEFAULTS, SubpixelParameters, TipKind
from simtip.detect.subpixel.scenery import POSE, Scenery, scenery_of
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_fit import fit
from simtip.detect.subpixel.shaft_pixels import BLOCK_ROWS, edges_px
from simtip.detect.subpixel.sight import tilt
from simtip.detect.subpixel.start import wedge_start
from simtip.detect.subpixel.tip import BAD_MISFIT, TipFit, fit_tip, like, usual_starts
from simtip.detect.subpixel.trace import Trace, trace
from simtip.geometry import Array

LEAST_ROWS = 28
"""Of shaft, to fit it."""

MOST_DEPTH_PX = 160.0
"""Of a tip's own rows that are compared."""

DEPTH_SHARE = 1.25
"""Of what the edges suggest: a bevel's cut goes on after its edge has met the shaft's side."""

CLEAR_PX = 4
"""Between a tip's end and the shaft's last row."""

STRAYED_PX = 1.0
"""A shaft fitted so far from where it was traced is traced anew."""

START_BLURS = (
    *((variance, 0.0) for variance in (0.03, 0.6, 2.5)),
    *((variance, share) for share in (0.95, 0.5) for variance in (0.25, 0.7, 1.5, 3.0)),
)
"""Variance, px^2, and the disc's share: from each the shaft's fit begins, and the best is kept."""

WORST_SHAFT_MISFIT = 100.0

UNEVEN_MISFIT = 20.0
"""A shaft that fits worse is tried anew with half its rows."""

FITTING_MISFIT = 2.0
"""A tip that fits so well is taken, and only what looks nearly like it tried beside it."""

OFF_AXIS = 0.3
"""A tip so far from the axis, in half widths, is first taken for a bevel."""

EDGE_SHORT_PX = 0.2
"""By which a half width by the edges' middles usually falls short: rims are brighter than what
lies within them."""

WIDTH_SLACK_PX = 0.35

EDGE_PARTS, EDGE_VARIANCE_PX2, EDGE_PASSES = 4, 0.6, 3
"""Parts of the shaft whose mean edges are looked for, and the blur that is allowed for there; it is
looked anew around a shaft that was moved by more than a pixel."""

GOOD_MISFIT = 4.0

TWINS = ("bevel", "bevel_away")
"""Each other's mirror image in depth: where one fits badly, the other may begin."""

NEAR = 1.5
"""Of bad fits ended in haste, those with at most so many times the best one's cost are ended."""

TRIALS = {
    "auto": ("cone", "wedge", "bevel", "bevel_away", "round"),
    "cone": ("cone",),
    "round": ("round",),
    "wedge": ("wedge",),
    "bevel": ("bevel", "bevel_away"),
}


class NoNeedleError(Exception):
    """A candidate is no needle, or its tip cannot be measured; the text says why."""

    def __init__(self, status: TipStatus, reason: str) -> None:
        super().__init__(reason)
        self.status = status
        self.reason = reason


@dataclass(frozen=True, eq=False)
class Analysis:
    """A needle in one picture.

    Attributes
    ----------
    frame
        Turns the picture so that the needle hangs tip down; all else is in that turned picture.
    trace, shaft, scenery, tip
        What was found in each step.
    """

    frame: Frame
    trace: Trace
    shaft: Shaft
    scenery: Scenery
    tip: TipFit

    @property
    def tip_px(self) -> Array:
        """The apex (2,) u, v in the picture as it is."""
        return self.frame.points_back(self.tip.tip)

    @property
    def axis_px(self) -> Array:
        """Direction (2,) from the tip to the hub in the picture as it is."""
        slope = float(self.shaft.slope(np.array(self.tip.values[0])))
        return self.frame.vectors_back(np.array([-slope, -1.0]))

    @property
    def covariance_px(self) -> Array:
        """Covariance (2, 2) of `tip_px`, px^2."""
        turn = self.frame.vectors_back(np.eye(2)).T
        found: Array = turn @ self.tip.tip_covariance @ turn.T
        return found * max(1.0, self.tip.misfit)


def analyse(image: Image, parameters: SubpixelParameters = DEFAULTS) -> Analysis:
    """Find the needle in a picture and measure it.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16.
    parameters
        See there.

    Raises
    ------
    NoNeedleError
        There is none, or its tip is not in the picture.
    InputError
        The array is no image of a supported kind.
    """
    # Its matrices are small: threads of BLAS would only wait for each other.
    with _blas().limit(limits=1, user_api="blas"):
        return _analysed(image, parameters)


@cache
def _blas() -> ThreadpoolController:
    return ThreadpoolController()


def _analysed(image: Image, parameters: SubpixelParameters) -> Analysis:
    gray = coarse_gray(image, parameters.full_scale)
    widths = parameters.min_width_px, parameters.max_width_px
    bands = find_bands(gray, widths) or find_bands(gray, widths, reduce=1)
    if not bands:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"no two parallel edges {widths[0]:g} to {widths[1]:g} px apart were found",
        )
    fine = mean_gray(image, parameters.full_scale)
    failures = []
    best: Analysis | None = None
    for band in bands[: parameters.candidates]:
        if best is not None and best.tip.misfit < BAD_MISFIT and _within(best, band):
            continue
        try:
            found = _measured(fine, gray, band, parameters)
        except NoNeedleError as error:
            failures.append(error)
            continue
        if best is None or found.tip.misfit < best.tip.misfit / 2:
            best = found
        if best.tip.misfit < GOOD_MISFIT:
            break
    if best is None:
        raise failures[0]
    return best


def _within(found: Analysis, band: Band) -> bool:
    """Say whether a band is a part of a needle already measured: a highlight along it."""
    centre = found.frame.points(band.centre)
    v = np.array(centre[1])
    off = abs(centre[0] - float(found.shaft.axis_u(v)))
    return bool(off < float(found.shaft.half_px(v)) + 1)


def _measured(
    image: NDArray[np.float32], gray: Gray, band: Band, parameters: SubpixelParameters
) -> Analysis:
    frame, traced = _hanging(gray, band)
    turned = frame.view(image)
    begun = _first_shaft(traced)
    v_end, wedge = _first_wedge(traced, begun)
    half = float(begun.half_px(np.array(v_end)))
    depth = max(wedge[1], wedge[2]) * half
    rows = traced.rows[traced.rows < v_end - depth - CLEAR_PX]
    if len(rows) < LEAST_ROWS:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"only {len(rows)} rows of straight shaft were seen; {LEAST_ROWS} are needed",
        )
    shaft = _even_shaft(turned, rows[-MOST_ROWS:], begun)
    traced = _traced_anew(frame.view(gray), shaft, begun) or traced
    v_end, wedge = _first_wedge(traced, shaft)
    widths = shaft.half_px(np.array([float(rows[0]), v_end]))
    if not (widths.min() > 0 and np.diag(shaft.covariance).min() > 0):
        raise NoNeedleError(TipStatus.NOT_FOUND, "the shaft's edges cannot be fitted")
    if shaft.misfit > WORST_SHAFT_MISFIT:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"what was seen is no straight, even shaft (misfit {shaft.misfit:.0f})",
        )
    centre = np.array(parameters.centre_px or ((image.shape[1] - 1) / 2, (image.shape[0] - 1) / 2))
    focal = parameters.focal_px or float(max(image.shape))
    view_tilt = tilt(shaft, v_end, focal, frame.points(centre))
    # A guessed camera bends the shaft's begin where nothing may be bent.
    tilts = view_tilt, view_tilt if parameters.focal_px else 0.0
    depth = max(*wedge[1:3]) * half * DEPTH_SHARE

    def scenery(depth: float) -> Scenery:
        depth = min(depth, MOST_DEPTH_PX) + 2 * CLEAR_PX
        return scenery_of(turned, shaft, v_end, depth, traced.level, tilts)

    seen = scenery(depth)
    tip = _best_tip(seen, v_end, wedge, _order(wedge, parameters.tip))
    needed = tip.family.depth(tip.values[2], tip.values[POSE:])
    if tip.family.name.startswith("bevel") and needed > depth:
        # A bevel's cut goes on beyond where its edge meets the shaft's side.
        seen = scenery(needed)
        sure = tip.misfit < FITTING_MISFIT
        tip = _best_tip(seen, v_end, wedge, (tip.family.name,) if sure else TRIALS["bevel"], tip)
    return Analysis(frame, traced, shaft, seen, tip)


def _order(wedge: Array, kind: TipKind) -> tuple[str, ...]:
    """Give the families to try, the likely ones first."""
    if kind == "auto" and abs(wedge[0]) > OFF_AXIS:
        return ("bevel", "bevel_away", "wedge", "cone", "round")
    return TRIALS[kind]


def _hanging(gray: Gray, band: Band) -> tuple[Frame, Trace]:
    """Turn the picture so that the band hangs tip down: the end within the picture is the tip."""
    found = []
    for direction in (band.direction, -band.direction):
        frame = Frame.down(direction, gray.shape)
        centre, along = frame.points(band.centre), frame.vectors(direction)
        slope = along[0] / along[1]
        line = (float(centre[0] - slope * centre[1]), float(slope))
        traced = trace(frame.view(gray), line, band.width_px * float(np.hypot(1, slope)))
        if traced is not None:
            found.append((frame, traced))
    inside = [(frame, traced) for frame, traced in found if not traced.at_bottom]
    if not found:
        raise NoNeedleError(TipStatus.NOT_FOUND, "no band of one width goes on long enough")
    if not inside:
        raise NoNeedleError(
            TipStatus.TOUCHES_BORDER, "the needle leaves the picture at both ends: no tip in it"
        )
    if len(inside) == 1 or inside[0][1].at_top:
        return inside[0]
    # Both ends are in the picture: the sharper one is the tip.
    lengths = []
    for _, traced in inside:
        _, wedge = _first_wedge(traced, _first_shaft(traced))
        lengths.append(wedge[1] + wedge[2])
    return inside[int(np.argmax(lengths))]


def _traced_anew(gray: Gray, shaft: Shaft, begun: Shaft) -> Trace | None:
    """Trace a shaft that turned out to lie elsewhere, or to be wider: where one side shines."""
    v = np.array(shaft.origin)
    half, slope = float(shaft.half_px(v)), float(shaft.slope(v))
    u = float(shaft.axis_u(v))
    if max(abs(u - begun.axis_u(v)), abs(half - begun.half_px(v))) < STRAYED_PX:
        return None
    return trace(gray, (u - slope * shaft.origin, slope), 2 * half * float(np.hypot(1, slope)))


def _first_shaft(traced: Trace) -> Shaft:
    """Give a straight shaft through the middles of the edges, those that stray left out."""
    v = traced.rows.astype(np.float64)
    middle, width = (traced.left + traced.right) / 2, traced.right - traced.left
    usual = float(np.nanmedian(width))
    with np.errstate(invalid="ignore"):
        good = np.isfinite(middle) & (np.abs(width - usual) < 0.15 * usual + 1)
    if good.sum() < LEAST_ROWS:
        raise NoNeedleError(
            TipStatus.NOT_FOUND, f"only {int(good.sum())} rows have the needle's usual width"
        )
    origin, scale = float(v[-1]), float(len(v))
    t = (v - origin) / scale
    for _ in range(3):
        line = np.polyfit(t[good], middle[good], 1)
        off = np.abs(middle - np.polyval(line, t))
        with np.errstate(invalid="ignore"):
            kept = good & (off < 2.5 * max(float(np.median(off[good])), 0.3))
        if kept.sum() >= LEAST_ROWS:
            good = kept
    usual = float(np.median(width[good]))
    slope = float(line[0]) / scale
    return Shaft(
        origin,
        scale,
        np.array([line[1], line[0], 0.0, 0.0]),
        np.array([usual / 2 / np.hypot(1, slope), 0.0, 0.0]),
        np.full(2, 0.3),
        np.array([1.0, 0.005]),
        np.zeros((0, 0)),
        np.inf,
    )


def _first_wedge(traced: Trace, shaft: Shaft) -> tuple[float, Array]:
    v = traced.rows.astype(np.float64)
    incline = float(np.hypot(1, shaft.slope(v[-1])))
    return wedge_start(
        traced.rows, traced.left, traced.right, shaft.axis_u(v), shaft.half_px(v), incline
    )


def _even_shaft(image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft) -> Shaft:
    """Fit the shaft; where a highlight comes and goes along it, only the part next to the tip."""
    shaft = _fitted_shaft(image, rows, begun)
    while shaft.misfit > UNEVEN_MISFIT and len(rows) >= 8 * BLOCK_ROWS:
        rows = rows[len(rows) // 2 :]
        shaft = _fitted_shaft(image, rows, begun)
    return shaft


def _fitted_shaft(image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft) -> Shaft:
    """Fit the shaft from several blurs; short ones as straight lines of even width."""
    origin, scale = float(rows[-1]), float(len(rows))
    short = len(rows) < 4 * BLOCK_ROWS
    slope = float(begun.slope(np.array(origin)))
    axis = np.array([float(begun.axis_u(np.array(origin))), slope * scale, 0.0, 0.0])
    width = np.array([begun.width[0], 0.0, 0.0])
    moved = replace(
        begun,
        origin=origin,
        scale=scale,
        axis=axis[:2] if short else axis,
        width=width[:2] if short else width,
    )
    moved = replace(moved, variance=np.full(2, EDGE_VARIANCE_PX2))
    for _ in range(EDGE_PASSES):
        before, moved = moved, _between_edges(image, rows, moved)
        if abs(moved.axis[0] - before.axis[0]) + abs(moved.width[0] - before.width[0]) < 1:
            break
    half = float(moved.width[0])
    starts = [
        replace(moved, variance=np.full(2, variance), disc_share=share)
        for variance, share in START_BLURS
    ]

    def likely(one: Shaft) -> bool:
        # In a blurred picture a wider, sharper needle with bright rims looks nearly the same.
        return bool(abs(one.width[0] - half) < _slack_px(one))

    try:
        return fit(image, rows, starts, likely)
    except np.linalg.LinAlgError as error:
        raise NoNeedleError(
            TipStatus.NOT_FOUND, "the shaft's brightness cannot be fitted"
        ) from error


def _between_edges(image: NDArray[np.float32], rows: NDArray[np.intp], begun: Shaft) -> Shaft:
    """Move a shaft between its mean edges, and taper it as those of its parts do."""
    parts = np.array_split(rows, EDGE_PARTS if len(begun.width) > 1 else 1)
    edges = np.array([edges_px(image, part, begun) for part in parts])
    t = begun.t(np.array([part.mean() for part in parts]))
    half = edges.mean(axis=1) + EDGE_SHORT_PX
    width = begun.width.copy()
    width[:2] = np.polyfit(t, half, 1)[::-1] if len(parts) > 1 else half
    axis = begun.axis.copy()
    incline = float(np.hypot(1, begun.slope(np.array(begun.origin))))
    axis[0] += float(np.mean(edges[:, 1] - edges[:, 0])) / 2 * incline
    return replace(begun, axis=axis, width=width)


def _slack_px(shaft: Shaft) -> float:
    """Give how far a half width may be from what the edges' traces say."""
    return WIDTH_SLACK_PX + 0.15 * float(np.sqrt(shaft.variance.max()))


def _best_tip(
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
        if best is not None and best.misfit < FITTING_MISFIT and not _kin(name, best):
            continue
        family = FAMILIES[name]
        close = best or before
        starts = like(family, close)
        again = best is None and before is not None and before.misfit < FITTING_MISFIT
        if not starts or (name.startswith("bevel") and not again):
            few = bool(starts) and close is not None and close.misfit < GOOD_MISFIT
            starts += usual_starts(scenery, family, v_end, begin, few=few)
        try:
            found = fit_tip(scenery, family, starts, _rival(name, best), hasty=True)
        except np.linalg.LinAlgError:
            continue
        if found is None:
            continue
        tried.append(found)
        if best is None or found.better_than(best):
            best = found
    if best is None:
        raise NoNeedleError(TipStatus.NOT_FOUND, "no outline fits the needle's end")
    if best.misfit > GOOD_MISFIT:
        # None was better: the haste is over.
        return _unhurried(scenery, best, tried)
    return _undecided(best, tried)


def _undecided(best: TipFit, tried: list[TipFit]) -> TipFit:
    """Let a cone's fit count beside a wedge's that is about as good, and the other way round."""
    for one in tried:
        if {one.family.name, best.family.name} == {"cone", "wedge"}:
            return best.or_nearly(one)
    return best


def _unhurried(scenery: Scenery, best: TipFit, tried: list[TipFit]) -> TipFit:
    """Fit the best, what came near it and its twins to the end, and give the best of them."""
    near = best.cost * NEAR
    ahead = sorted(tried, key=lambda one: one.cost)
    ways = [(one.family, one.values) for one in ahead if one.cost < near]
    ways += [(FAMILIES[name], start) for name in TWINS for start in _alike(name, best)]
    for family, start in ways:
        ended = fit_tip(scenery, family, [start])
        if ended is not None and ended.cost < best.cost:
            best = ended
            if best.misfit < FITTING_MISFIT:
                break
    if best.family.name == "wedge":
        cone = fit_tip(scenery, FAMILIES["cone"], like(FAMILIES["cone"], best), best)
        if cone is not None and cone.better_than(best):
            return cone
    return best


def _alike(name: str, best: TipFit) -> list[Array]:
    return like(FAMILIES[name], best) if {name, best.family.name} == set(TWINS) else []


def _rival(name: str, best: TipFit | None) -> TipFit | None:
    """Give the fit to be beaten; none where a bevel fits badly, and may be its mirror image."""
    if best is None or best.misfit < FITTING_MISFIT:
        return best
    return None if {name, best.family.name} == set(TWINS) else best


def _kin(name: str, best: TipFit) -> bool:
    """Say whether a family is to be tried beside one that fits: one looks like the other."""
    kin = {"wedge": ("cone",), "cone": (), "round": (), "bevel": (), "bevel_away": ("bevel",)}
    return best.family.name in kin[name]


MOST_ROWS = 1200
"""Of shaft that are fitted, those next to the tip."""
