"""Find a needle's tip below its shaft: how far up it reaches, and what else may be in the way."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from simtip.detect.subpixel.behind import with_clutter
from simtip.detect.subpixel.highlight import without_highlight
from simtip.detect.subpixel.likeness import likeness
from simtip.detect.subpixel.outline import FAMILIES, usual_depth
from simtip.detect.subpixel.parameters import TipKind
from simtip.detect.subpixel.scenery import BLUR, POSE, Scenery, scenery_of
from simtip.detect.subpixel.seam import without_seam
from simtip.detect.subpixel.shaft import Shaft
from simtip.detect.subpixel.tip import TipFit, fit_tip
from simtip.detect.subpixel.tip_choice import (
    POOR_MISFIT,
    TRIALS,
    begun_elsewhere,
    best_tip,
    or_cone,
    order,
    refitted,
)
from simtip.detect.subpixel.tip_start import TWINS, Start, best_start, usual_values
from simtip.geometry import Array

MOST_DEPTH_PX = 160.0
"""Of a tip's own rows that are compared."""

DEPTH_SHARE = 1.25
"""Of what the edges suggest: a bevel's cut goes on after its edge has met the shaft's side."""

CLEAR_PX = 4
"""Between a tip's end and the shaft's last row."""

CLUTTER_PASSES = 2
"""The ground is looked at again once the tip's outline is better known."""

MOST_HIGHLIGHTS, HIGHLIGHT_SHARE = 4, 0.4
"""Times that a highlight's pixels are looked for, and what of the misfit may be left then."""

PALE_BEYOND = 6.0
"""How far beyond the last row that shows the needle the end of a facet may be that hardly differs
from the background, in half widths."""

PALE_COTS, PALE_AZIMUTHS = (1.5, 2.5, 3.5), (0.6, 1.1, np.pi / 2, np.pi - 1.1, np.pi - 0.6)
"""Shapes at which the fit of such a bevel begins."""

DOUBTFUL, DOUBT, DOUBT_SHARE = 3.0, 3.0, 0.025
"""A misfit beyond which there may be a pale facet, how many times the shaft's it has to be, and of
the contrast the residual."""

FAINT, FAINT_LIKENESS, FAINT_SHARE = 1.25, 1.75, 0.85
"""Of a bevel, times the shaft's misfit or 1, and how alike neighbouring residuals are; and what of
the misfit one may leave that fits so well."""

PALE_TRIED, PALE_SHARE = 3, 0.5
"""So many are fitted, and what of the misfit the best may leave."""

SEAMED = {"cone": ("cone", "wedge"), "wedge": ("wedge", "cone"), "round": ("round",)}
"""What a tip without a facet may be, once the pixels where it meets the shaft are left out."""

MOST_TAPER = 0.2
"""By which a needle's width may change until there."""

SOFT_PX2 = 0.5
"""Variance of a blur that takes long to work out: such pictures are tried in haste."""


@dataclass(frozen=True, eq=False)
class TipSearch:
    """Where a tip is sought.

    Attributes
    ----------
    image
        (H, W) gray values, turned.
    shaft
        The shaft's fit.
    v_end, begin
        The last row that shows the needle, and what the edges suggest, see
        `simtip.detect.subpixel.start`.
    level, contrast
        Of the background, and of the needle against it, DN.
    tilts
        See `scenery_of`.
    """

    image: NDArray[np.float32]
    shaft: Shaft
    v_end: float
    begin: Array
    level: float
    contrast: float
    tilts: tuple[float, float]

    def found(self, kind: TipKind) -> tuple[Scenery, TipFit]:
        """Fit the tip; with the pixels it was fitted to.

        Raises
        ------
        NoNeedleError
            No outline fits.
        """
        kinds = order(self.begin, kind)
        seen, tip = self._usual(kinds)
        if kind in ("auto", "bevel") and self._doubtful(seen, tip):
            seen, tip = self._pale_facet(seen, tip)
        if _has_seam(seen, tip):
            names = tuple(name for name in SEAMED[tip.family.name] if name in kinds)
            seen = without_seam(seen, tip)
            tip = best_tip(seen, self.v_end, self.begin, names, tip)
        return self._before_clutter(*self._without_highlights(seen, tip, kinds))

    def end(self, seen: Scenery, tip: TipFit) -> float:
        """Give the row about which the needle ends; a pale facet's own, which no edge shows.

        Before clutter nothing tells a pale facet.
        """
        depth = tip.family.depth(tip.values[2], tip.values[POSE:])
        even = not np.any(seen.clutter)
        pale = tip.family.name == "bevel" and tip.misfit < POOR_MISFIT and even
        end = float(tip.tip[1])
        return end if pale and end - depth <= self.v_end <= end else self.v_end

    @property
    def _half(self) -> float:
        return float(self.shaft.half_px(np.array(self.v_end)))

    def _scenery(self, depth: float, beyond: float = 0.0) -> Scenery:
        depth = min(depth, MOST_DEPTH_PX) + 2 * CLEAR_PX + beyond
        end = self.v_end + beyond
        return scenery_of(self.image, self.shaft, end, depth, self.level, self.tilts)

    def _doubtful(self, seen: Scenery, tip: TipFit) -> bool:
        """Say whether a tip may be another: it fits badly, by the noise and by the contrast.

        Of a bevel something that goes on over some pixels, be it as faint as it may, is enough.
        """
        if tip.family.name in TWINS and tip.misfit > FAINT * max(1.0, self.shaft.misfit):
            left = (tip.residual * seen.precision).reshape(seen.window.shape)
            if likeness(left) > FAINT_LIKENESS:
                return True
        most = min(POOR_MISFIT, max(DOUBTFUL, DOUBT * self.shaft.misfit))
        return tip.misfit > most and seen.left_dn(tip.residual) > DOUBT_SHARE * self.contrast

    def _usual(self, kinds: tuple[str, ...]) -> tuple[Scenery, TipFit]:
        depth = max(*self.begin[1:3]) * self._half * DEPTH_SHARE
        if kinds[0] == "bevel":
            depth = max(depth, self._half * usual_depth(FAMILIES["bevel"], self.begin))
        seen = self._scenery(depth)
        begun = self._begun(seen, kinds[0]) if kinds[0] in SEAMED and not seen.rim_tilt else None
        if begun is not None and begun.misfit >= POOR_MISFIT:
            begun = None
        if begun is not None:
            seen = without_seam(seen, begun)
        tip = best_tip(seen, self.v_end, self.begin, kinds, begun)
        if tip.family.facet is not None and seen.seamless:
            seen = self._scenery(depth)
            tip = best_tip(seen, self.v_end, self.begin, (tip.family.name,), tip)
        needed = tip.family.depth(tip.values[2], tip.values[POSE:])
        beyond = self._unseen(seen, tip)
        if tip.family.name in TWINS and (needed > depth or beyond > 0):
            # A bevel's cut goes on beyond where its edge meets the shaft's side, and a pale one's
            # end beyond the last row that shows the needle.
            seen = self._scenery(max(needed, depth), beyond)
            names = (tip.family.name,) if tip.misfit < POOR_MISFIT else TRIALS["bevel"]
            tip = best_tip(seen, self.v_end, self.begin, names, tip)
        return seen, tip

    def _unseen(self, seen: Scenery, tip: TipFit) -> float:
        """Give by how much further down pixels have to be compared to see a tip's end, px."""
        blur = 3 * float(np.sqrt(tip.values[BLUR]))
        end = seen.window.v + seen.window.height
        missing = min(float(tip.tip[1]) + CLEAR_PX + blur, len(self.image)) - end
        return min(missing, self._half * PALE_BEYOND) if missing > 0 else 0.0

    def _begun(self, seen: Scenery, name: str) -> TipFit | None:
        """Fit the family that is tried first, in haste."""
        family = FAMILIES[name]
        values = usual_values(seen, family, self.v_end, self.begin)
        try:
            return fit_tip(seen, family, best_start(seen, family, values), hasty=True)
        except np.linalg.LinAlgError:
            return None

    def _pale_facet(self, seen: Scenery, tip: TipFit) -> tuple[Scenery, TipFit]:
        """Try a bevel that goes on beyond the needle's last row, its facet being about as bright.

        As the background is; then the rows seen end where the facet begins.
        """
        far = self._scenery(self._half * 2 * max(PALE_COTS), self._half * PALE_BEYOND)
        if abs(far.half_px - self._half) > MOST_TAPER * self._half:
            return seen, tip
        family, pale = FAMILIES["bevel"], tip
        for start in self._pale_starts(far)[:PALE_TRIED]:
            try:
                found = fit_tip(far, family, start, hasty=far.variance_px2 > SOFT_PX2)
            except np.linalg.LinAlgError:
                continue
            if found is not None and found.misfit < pale.misfit:
                pale = found
        most = min(POOR_MISFIT, PALE_SHARE * tip.misfit)
        if tip.misfit > DOUBTFUL:
            most = max(most, DOUBTFUL)
        enough, twin = FAINT * max(1.0, self.shaft.misfit), tip.family.name in TWINS
        better = pale.misfit < most
        if better or (tip.misfit < DOUBTFUL and pale.misfit < FAINT_SHARE * tip.misfit):
            pale = refitted(far, pale)
            better = better or twin or pale.misfit < enough
        if not better:
            return seen, begun_elsewhere(seen, tip) if twin else tip
        return far, pale if pale.misfit < enough else begun_elsewhere(far, pale)

    def _pale_starts(self, far: Scenery) -> list[Start]:
        """Give bevels of which the shaft ends, at a side, in the last row seen; the best first."""
        starts = []
        for cot, azimuth in product(PALE_COTS, PALE_AZIMUTHS):
            v = self.v_end + self._half * cot * (1 - abs(np.cos(azimuth)))
            values = np.array([v, 0, far.half_px, far.begun_px2, 0, cot, azimuth])
            starts.append(Start.at(far, FAMILIES["bevel"], values))
        return sorted(starts, key=lambda one: one.found.cost)

    def _before_clutter(self, seen: Scenery, tip: TipFit) -> tuple[Scenery, TipFit]:
        """Fit a tip that fits badly before an uneven ground, which counts as noise."""
        if tip.misfit < POOR_MISFIT:
            return seen, tip
        for _ in range(CLUTTER_PASSES):
            rough = with_clutter(seen, tip, self.contrast)
            if rough is None:
                break
            seen, tip = rough, refitted(rough, tip)
        return seen, tip

    def _without_highlights(
        self, seen: Scenery, tip: TipFit, kinds: tuple[str, ...]
    ) -> tuple[Scenery, TipFit]:
        """Fit a tip that fits badly without a highlight's pixels, if that is what is amiss."""
        before = seen, tip
        for _ in range(MOST_HIGHLIGHTS):
            if tip.misfit < POOR_MISFIT:
                break
            darker = without_highlight(seen, tip, self.contrast)
            if darker is None:
                break
            seen, tip = darker, refitted(darker, tip)
        if tip.misfit >= HIGHLIGHT_SHARE * before[1].misfit:
            return before
        return seen, or_cone(seen, tip) if "cone" in kinds else tip


def _has_seam(seen: Scenery, tip: TipFit) -> bool:
    """Say whether a tip's pixels have those where it meets the shaft, and no camera tells how."""
    return seen.rim_tilt == 0 and tip.family.facet is None and not seen.seamless
