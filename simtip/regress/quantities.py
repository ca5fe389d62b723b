"""What is tested of two samples of one condition: detection, shifts, spreads and outliers.

On the same images (`paired`) trials are compared one by one; with fresh noise as two samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array
from simtip.regress.change import DETECTION, OUTLIERS, SHIFT, SPREAD, Change
from simtip.regress.exact import Tested, paired_t, rank_sum
from simtip.regress.sample import NEEDLE_AXES, VIEWS, Sample, gross
from simtip.regress.tolerance import Tolerance

FLOOR_PX = 0.02
"""Scatter that is presumed where pairs show less: of fits and of roundings, px."""

SIDEWAYS = 0.05
"""Of a shift in a view, that its part along or across the needle has to be to count: whole pixels
are seldom quite along it."""

FEWEST = 2
"""Tips in a view, before and after, below which nothing is said of where they are."""


@dataclass(frozen=True, eq=False)
class Pair:
    """One condition before and after, without outliers.

    Attributes
    ----------
    before, after
        The samples.
    paired
        Whether both are of the same images.
    gross
        Which tips are outliers, (n, 2) and (m, 2).
    """

    before: Sample
    after: Sample
    paired: bool
    gross: tuple[NDArray[np.bool_], NDArray[np.bool_]]

    @classmethod
    def of(cls, before: Sample, after: Sample, *, paired: bool) -> Pair:
        """Put two samples side by side."""
        return cls(before, after, paired, gross(before, after))

    def errors(self, view: int, *, needle: bool) -> tuple[Array, Array]:
        """Give a view's errors, (n, 2) and (m, 2); in pairs of equal number and order.

        Parameters
        ----------
        view
            0 or 1.
        needle
            Along and across the needle, else u and v.
        """
        marks = self.gross
        kept: list[NDArray[np.bool_]] = [
            np.asarray(s.seen(view) & ~mark[:, view])
            for s, mark in zip((self.before, self.after), marks, strict=True)
        ]
        if self.paired:
            both = np.asarray(kept[0] & kept[1])
            kept = [both, both]
        values = [s.needle_px if needle else s.error_px for s in (self.before, self.after)]
        return values[0][kept[0], view], values[1][kept[1], view]

    @property
    def outliers(self) -> tuple[Array, Array]:
        """Trials with an outlier in any view, 0 or 1; of those with a tip in any view."""
        found: list[NDArray[np.bool_]] = []
        for sample, marks in zip((self.before, self.after), self.gross, strict=True):
            seen = sample.seen(0) | sample.seen(1)
            far = np.asarray(marks.any(axis=1))
            found.append(far if self.paired else far[seen])
        return found[0].astype(np.float64), found[1].astype(np.float64)


def changes_of(pair: Pair, tolerance: Tolerance) -> list[Change]:
    """Test everything of one condition."""
    found = [detection(pair, tolerance), _far_off(pair, tolerance)]
    for view in range(2):
        x, y = pair.errors(view, needle=True)
        if min(len(x), len(y)) < FEWEST:
            continue
        for axis in range(2):
            found.append(_shift(pair, view, axis, (x, y), tolerance))
            found.append(_spread(view, axis, x[:, axis], y[:, axis], tolerance))
    return found


def detection(pair: Pair, tolerance: Tolerance) -> Change:
    """Test how much is detected; of marks 0 and 1 the rank sum is Fisher's exact test."""
    x, y = pair.before.detected, pair.after.detected
    told = rank_sum(x, y)
    before, after = float(x.mean()), float(y.mean())
    return rate_change(DETECTION, before, after, told, tolerance.rate)


def _far_off(pair: Pair, tolerance: Tolerance) -> Change:
    """Test how many tips are far off, likewise; shifts and spreads leave these out."""
    x, y = pair.outliers
    if not (len(x) and len(y)):
        return rate_change(OUTLIERS, 0.0, 0.0, Tested(1.0, 1.0), tolerance.rate)
    before, after = float(x.mean()), float(y.mean())
    return rate_change(OUTLIERS, before, after, rank_sum(x, y), tolerance.rate)


def rate_change(kind: str, before: float, after: float, told: Tested, tolerance: float) -> Change:
    """Say how a rate changed: of detections more is better, of outliers less."""
    change = after - before
    gain = change if kind == OUTLIERS else -change
    beyond = abs(change) > tolerance
    return Change(
        *(kind, "both", "", before, after, change, tolerance),
        *(told.p, told.least_p, gain, beyond),
    )


def _shift(
    pair: Pair, view: int, axis: int, errors: tuple[Array, Array], tolerance: Tolerance
) -> Change:
    whole = float(np.linalg.norm(errors[1].mean(axis=0) - errors[0].mean(axis=0)))
    x, y = (values[:, axis] for values in errors)
    told = paired_t(y - x, FLOOR_PX) if pair.paired else rank_sum(x, y)
    least = max(tolerance.bias_px, tolerance.bias_sigma * deviation(x), SIDEWAYS * whole)
    before, after = float(x.mean()), float(y.mean())
    return shift_change(VIEWS[view], NEEDLE_AXES[axis], before, after, told, least)


def shift_change(
    view: str, axis: str, before: float, after: float, told: Tested, least: float
) -> Change:
    """Say how a mean error changed; it is worse if it is farther from 0 by more than `least`."""
    change, farther = after - before, abs(after) - abs(before)
    gain = farther if abs(farther) > least else 0.0
    return Change(
        *(SHIFT, view, axis, before, after, change, least),
        *(told.p, told.least_p, gain, abs(change) > least),
    )


def _spread(view: int, axis: int, x: Array, y: Array, tolerance: Tolerance) -> Change:
    """Test scatter by ranks of distances, from the common median and from each one's own.

    With the common one the test is exact; the own ones keep a shift from being taken for scatter.
    Where a shift is so large that both lie off the common median alike, only a larger change of
    scatter shows.
    """
    own = rank_sum(distances(x), distances(y))
    middle = float(np.quantile(np.concatenate([x, y]), 0.5, method="lower"))
    common = rank_sum(np.abs(x - middle), np.abs(y - middle))
    told = own if own.p >= common.p else common
    return spread_change(
        VIEWS[view], NEEDLE_AXES[axis], deviation(x), deviation(y), told, tolerance.spread
    )


def spread_change(
    view: str, axis: str, before: float, after: float, told: Tested, least: float
) -> Change:
    """Say how a standard deviation changed, px."""
    ratio = spread_ratio(before, after)
    beyond = max(ratio, 1 / ratio) > least
    return Change(
        *(SPREAD, view, axis, before, after, ratio, least),
        *(told.p, told.least_p, ratio - 1, beyond),
    )


def spread_ratio(before: float, after: float) -> float:
    """Give the ratio of two standard deviations, to each of which the floor is added."""
    return float(np.hypot(after, FLOOR_PX) / np.hypot(before, FLOOR_PX))


def distances(values: Array) -> Array:
    """Give how far values lie from their median, one of them, so that equal ones stay at 0."""
    return np.abs(values - np.quantile(values, 0.5, method="lower"))


def deviation(values: Array) -> float:
    """Give the sample's standard deviation, 0 of a single value."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
