"""All that can be found out about a needle in one picture: shaft, tip, and how well."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from simtip.detect.gray import Gray
from simtip.detect.observation import TipStatus
from simtip.detect.protocol import Image
from simtip.detect.subpixel.bands import Band, find_bands
from simtip.detect.subpixel.first_look import (
    LEAST_ROWS,
    first_shaft,
    first_wedge,
    hanging,
    shaft_end,
    traced_anew,
)
from simtip.detect.subpixel.frame import Frame
from simtip.detect.subpixel.gray import coarse_gray, mean_gray
from simtip.detect.subpixel.no_needle import NoNeedleError
from simtip.detect.subpixel.parameters import DEFAULTS, SubpixelParameters
from simtip.detect.subpixel.saturated import without_saturated
from simtip.detect.subpixel.scenery import LEAN, Scenery
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.shaft_start import even_shaft
from simtip.detect.subpixel.sight import tilt, tilt_deviation
from simtip.detect.subpixel.tip import BAD_MISFIT, TipFit, by_tilt
from simtip.detect.subpixel.tip_choice import GOOD_MISFIT
from simtip.detect.subpixel.tip_search import CLEAR_PX, TipSearch
from simtip.detect.subpixel.trace import Trace
from simtip.geometry import Array

MOST_ROWS = 1200
"""Of shaft that are fitted, those next to the tip."""

WORST_SHAFT_MISFIT = 100.0

GUESSED = 0.7
"""Part by which a tilt may be off that was told with a guessed focal length."""

WORST_TIP_MISFIT, WORST_SHARE = 30.0, 0.06
"""A fit that is worse, both by the noise and by the needle's contrast, is none."""

MOSTLY, WORST_WITHIN = 0.5, 0.12
"""Least cover of a pixel that is mostly the needle's; a fit that is worse there, by the contrast,
is none, whatever lies behind the needle."""

BIN_PIXELS = 6
"""About so many pixels are averaged for one value that the shaft is fitted to."""

WORST_DEVIATION = 0.4
"""Of a tip's place that is told, in half widths."""

HIDDEN_SHARE, HIDDEN_PX = 0.5, 6.0
"""How far from the last row that shows the needle its apex may be: in half widths, and px more."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """A needle in one picture.

    Attributes
    ----------
    frame
        Turns the picture so that the needle hangs tip down; all else is in that turned picture.
    trace, shaft, scenery, tip
        What was found in each step.
    tilt_covariance
        (2, 2) px^2 of the tip, because of the sight's tilt, which the fit takes as known, if
        nothing but noise is left over.
    """

    frame: Frame
    trace: Trace
    shaft: Shaft
    scenery: Scenery
    tip: TipFit
    tilt_covariance: Array

    @property
    def misfit(self) -> float:
        """Mean squared residual over the camera's noise alone, whatever lies behind the needle."""
        counted = ~self.scenery.left_out
        shares = self.tip.residual[counted] ** 2 / self.scenery.noise[counted]
        return float(np.mean(shares))

    @property
    def tip_px(self) -> Array:
        """The apex (2,) u, v in the picture as it is."""
        return self.frame.points_back(self.tip.tip)

    @property
    def axis_px(self) -> Array:
        """Direction (2,) from the tip to the hub in the picture as it is."""
        slope = float(self.shaft.slope(np.array(self.tip.values[0]))) + self.tip.values[LEAN]
        return self.frame.vectors_back(np.array([-slope, -1.0]))

    @property
    def covariance_px(self) -> Array:
        """Covariance (2, 2) of `tip_px`, px^2."""
        turn = self.frame.vectors_back(np.eye(2)).T
        own = self.tip.unexplained * self.tip.tip_covariance
        own += max(1.0, self.tip.misfit) * self.tilt_covariance
        return np.asarray(turn @ own @ turn.T)


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
            f"no two parallel edges of something dark, {widths[0]:g} to {widths[1]:g} px apart, "
            "were found",
        )
    failures = []
    best: Analysis | None = None
    for band in bands[: parameters.candidates]:
        if best is not None and best.misfit < BAD_MISFIT and _within(best, band):
            continue
        fine = mean_gray(image, parameters.full_scale, band.surroundings(image.shape))
        try:
            found = _measured(fine, gray, band, parameters)
        except NoNeedleError as error:
            failures.append(error)
            continue
        if best is None or found.misfit < best.misfit / 2:
            best = found
        if best.misfit < GOOD_MISFIT:
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
    frame, traced = hanging(gray, band)
    begun = first_shaft(traced)
    v_end, wedge = first_wedge(traced, begun)
    half = float(begun.half_px(np.array(v_end)))
    depth = max(wedge[1], wedge[2]) * half
    end = shaft_end(frame.view(gray), traced, begun, v_end - depth)
    turned = without_saturated(frame.view(image), traced, end)
    rows = traced.rows[traced.rows < end - CLEAR_PX]
    if len(rows) < LEAST_ROWS:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"only {len(rows)} rows of straight shaft were seen; {LEAST_ROWS} are needed",
        )
    shaft = even_shaft(turned, rows[-MOST_ROWS:], begun)
    if shaft.width_held and _unlike(shaft, traced):
        # A bright streak beside an edge looks like one.
        shaft = even_shaft(turned, rows[-MOST_ROWS:], begun, any_width=True)
    traced = traced_anew(frame.view(gray), shaft, begun) or traced
    v_end, wedge = first_wedge(traced, shaft)
    widths = shaft.half_px(np.array([float(rows[0]), v_end]))
    if not (widths.min() > 0 and np.diag(shaft.covariance).min() > 0):
        raise NoNeedleError(TipStatus.NOT_FOUND, "the shaft's edges cannot be fitted")
    if _unlike(shaft, traced):
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"what was seen is no straight, even shaft (misfit {shaft.misfit:.0f})",
        )
    centre = np.array(parameters.centre_px or ((image.shape[1] - 1) / 2, (image.shape[0] - 1) / 2))
    focal = parameters.focal_px or float(max(image.shape))
    view_tilt = tilt(shaft, v_end, focal, frame.points(centre))
    # A guessed camera bends the shaft's begin where nothing may be bent.
    tilts = view_tilt, view_tilt if parameters.focal_px else 0.0
    search = TipSearch(turned, shaft, v_end, wedge, traced.level, traced.contrast, tilts)
    seen, tip = search.found(parameters.tip)
    spread = tilt_deviation(shaft, v_end, focal, frame.points(centre))
    if not parameters.focal_px:  # a guess, half of it off
        spread = float(np.hypot(spread, GUESSED * view_tilt))
    found = Analysis(frame, traced, shaft, seen, tip, _of_tilt(seen, tip, spread))
    _require_tip(found, search.end(seen, tip), half, turned.shape)
    return found


def _of_tilt(seen: Scenery, tip: TipFit, spread: float) -> Array:
    """Give what a tilt that is told to `spread` adds to the covariance (2, 2) of a bevel's tip."""
    if not tip.family.name.startswith("bevel"):
        return np.zeros((2, 2))
    moved = by_tilt(seen, tip) * spread
    return np.outer(moved, moved)


def _unlike(shaft: Shaft, traced: Trace) -> bool:
    """Say whether a shaft is no straight, even one, by the noise and by the needle's contrast."""
    left_dn = float(np.sqrt(shaft.misfit * float(shaft.noise_dn2(traced.level)) / BIN_PIXELS))
    return shaft.misfit > WORST_SHAFT_MISFIT and left_dn > WORST_SHARE * traced.contrast


def _require_tip(found: Analysis, v_end: float, half: float, shape: tuple[int, ...]) -> None:
    """Refuse a tip outside the picture, far from where the needle was seen to end, or unlike any.

    Raises
    ------
    NoNeedleError
        It is one of those.
    """
    seen, tip, traced = found.scenery, found.tip, found.trace
    u, v = tip.tip
    if traced.at_bottom or not (-0.5 <= u < shape[1] - 0.5 and -0.5 <= v < shape[0] - 0.5):
        raise NoNeedleError(TipStatus.TOUCHES_BORDER, "the needle's end leaves the picture")
    off = abs(float(v) - v_end)
    if off > HIDDEN_SHARE * half + HIDDEN_PX:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            f"the tip that fits best lies {off:.0f} px from where the needle was seen to end",
        )
    left_dn = seen.left_dn(tip.residual)
    bad = tip.misfit > WORST_TIP_MISFIT and left_dn > WORST_SHARE * traced.contrast
    within = (tip.found.cover.whole > MOSTLY) & ~seen.left_out
    most = traced.contrast**2
    unexplained = np.mean(tip.residual[within] ** 2 - seen.noise[within]) if within.any() else most
    within_dn = float(np.sqrt(max(unexplained, 0.0)))
    if bad or within_dn > WORST_WITHIN * traced.contrast:
        raise NoNeedleError(
            TipStatus.NOT_FOUND,
            "the needle's end looks like no tip that is known: a fit is "
            f"{max(left_dn, within_dn):.0f} DN off",
        )
    deviation = float(np.sqrt(np.linalg.eigvalsh(found.covariance_px)[-1]))
    if not deviation <= WORST_DEVIATION * seen.half_px:
        raise NoNeedleError(
            TipStatus.NOT_FOUND, f"where the tip is, is told to {deviation:.1f} px only"
        )
