"""How far measured displacements are from reference displacements.

Equations are those of Lin et al. (2020). Arrays in, so that a file and a simulation serve alike;
millimetres if the data are in millimetres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.capability.interval import (
    Array,
    Interval,
    ends,
    finite,
    mean_interval,
    mover,
    paired,
    spread,
    variance_interval,
)
from simtip.capability.regression import Regression, regress, squared_correlation

Pair = tuple[ArrayLike, ArrayLike]
"""Measured and reference values, (n,) each."""


def vision_displacements(points: ArrayLike) -> Array:
    """Give the distance of each tip position from the one before, Eq. 1.

    Parameters
    ----------
    points
        (n, 3) positions, mm, in any one frame.

    Returns
    -------
    displacements
        (n - 1,), mm.

    Raises
    ------
    ValueError
        The shape is wrong or a number is not finite.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise ValueError(f"expected finite positions (n, 3), not an array of {array.shape}")
    lengths: Array = np.linalg.norm(np.diff(array, axis=0), axis=1)
    return lengths


def laser_displacements(readings: ArrayLike) -> Array:
    """Give the distance of each reading (n,) of the reference from the one before, Eq. 2."""
    return np.abs(np.diff(finite(readings, 1, "readings")))


def displacement_errors(measured: ArrayLike, reference: ArrayLike) -> Array:
    """Give the errors of displacements, measured minus reference, Eq. 3; (n,) each."""
    y, x = paired(measured, reference, 1)
    return y - x


@dataclass(frozen=True)
class ErrorSummary:
    """Errors in a few figures, each with its interval; unit of the data.

    Attributes
    ----------
    n
        How many errors.
    mean, mean_ci
        Mean of the signed errors, Student's t.
    mean_abs, mean_abs_ci
        Mean of their sizes, Student's t of its logarithm.
    rms, rms_ci
        Root of the mean square; the interval is MOVER's of mean^2 + variance.
    max_abs
        The largest size seen. It has no interval: the largest of a normal population has no end.
    """

    n: int
    mean: float
    mean_ci: Interval
    mean_abs: float
    mean_abs_ci: Interval
    rms: float
    rms_ci: Interval
    max_abs: float

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            "n": self.n,
            "mean_mm": self.mean,
            "mean_ci_mm": ends(self.mean_ci),
            "mean_abs_mm": self.mean_abs,
            "mean_abs_ci_mm": ends(self.mean_abs_ci),
            "rms_mm": self.rms,
            "rms_ci_mm": ends(self.rms_ci),
            "max_abs_mm": self.max_abs,
        }


def summarise_errors(errors: ArrayLike, level: float = 0.95) -> ErrorSummary:
    """Sum up signed errors.

    Parameters
    ----------
    errors
        (n,), n at least 2.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        There are too few errors, or one is not finite.
    """
    e = finite(errors, 2, "errors")
    n, mean, sizes = len(e), float(e.mean()), np.abs(e)
    mean_abs, sd = float(sizes.mean()), spread(e)
    return ErrorSummary(
        n=n,
        mean=mean,
        mean_ci=mean_interval(mean, sd, n, level),
        mean_abs=mean_abs,
        mean_abs_ci=_positive_mean_interval(mean_abs, spread(sizes), n, level),
        rms=math.sqrt(float((e**2).mean())),
        rms_ci=_rms_interval(mean, sd, n, level),
        max_abs=float(sizes.max()),
    )


def _positive_mean_interval(mean: float, sd: float, n: int, level: float) -> Interval:
    """Give Student's t interval of the logarithm of a mean of sizes, taken back.

    Sizes of errors of both signs are skewed: the plain interval would lie too low.
    """
    if mean == 0:
        return Interval(0.0, 0.0)
    plain = mean_interval(0.0, sd / mean, n, level)
    return Interval(mean * math.exp(plain.low), mean * math.exp(plain.high))


def _rms_interval(mean: float, sd: float, n: int, level: float) -> Interval:
    """Give the interval of sqrt(mu^2 + sigma^2), by MOVER from those of mu^2 and of sigma^2."""
    square = mean**2 + sd**2 * (n - 1) / n
    # mean^2 estimates mu^2 + sigma^2 / n: what is over goes to the variance.
    of_mean = _square(mean_interval(mean, sd, n, level))
    of_variance = variance_interval(sd**2, n - 1, level)
    sum_ = mover([mean**2, sd**2], [of_mean, of_variance])
    shift = square - mean**2 - sd**2
    return Interval(sum_.low + shift, sum_.high + shift).root()


def _square(interval: Interval) -> Interval:
    small, large = sorted((interval.low**2, interval.high**2))
    return Interval(0.0 if interval.low <= 0 <= interval.high else small, large)


@dataclass(frozen=True)
class Accuracy:
    """How accurate displacements are.

    Attributes
    ----------
    errors
        Of the displacements.
    steps
        Of the steps, or None if there are none.
    linearity
        Bias against reference displacement: the errors regressed on the reference.
    r2_step, r2_cumulative
        Squared Pearson correlation of measured and reference steps, and displacements.
    r2_step_identity, r2_cumulative_identity
        1 - SSE / SST of the identity line, as `identity_r2` has it; below 0 if the measured values'
        own mean does better.
    """

    errors: ErrorSummary
    steps: ErrorSummary | None
    linearity: Regression | None
    r2_step: float | None
    r2_step_identity: float | None
    r2_cumulative: float | None
    r2_cumulative_identity: float | None

    def to_dict(self) -> dict[str, Any]:
        """Give plain numbers for JSON."""
        return {
            **self.errors.to_dict(),
            "r2_step": self.r2_step,
            "r2_step_identity": self.r2_step_identity,
            "r2_cumulative": self.r2_cumulative,
            "r2_cumulative_identity": self.r2_cumulative_identity,
            "linearity": None if self.linearity is None else self.linearity.to_dict(),
            "steps": None if self.steps is None else self.steps.to_dict(),
        }


def assess_accuracy(
    measured: ArrayLike,
    reference: ArrayLike,
    *,
    steps: Pair | None = None,
    cumulative: Pair | None = None,
    level: float = 0.95,
) -> Accuracy:
    """Compare measured displacements with those of the reference.

    Parameters
    ----------
    measured, reference
        (n,) the displacements that the errors are of; n at least 2.
    steps
        Measured and reference steps, one after the other, for ``r2_step``.
    cumulative
        Measured and reference displacements from the start of a run, for ``r2_cumulative``;
        without it, `measured` and `reference`.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        There are too few values, lengths differ, or a number is not finite.
    """
    y, x = paired(measured, reference, 2)
    whole = (y, x) if cumulative is None else paired(*cumulative, 2)
    apart = None if steps is None else paired(*steps, 2)
    return Accuracy(
        errors=summarise_errors(y - x, level),
        steps=None if apart is None else summarise_errors(apart[0] - apart[1], level),
        linearity=regress(y - x, x, level),
        r2_step=None if apart is None else squared_correlation(*apart),
        r2_step_identity=None if apart is None else identity_r2(*apart),
        r2_cumulative=squared_correlation(*whole),
        r2_cumulative_identity=identity_r2(*whole),
    )


def identity_r2(measured: ArrayLike, reference: ArrayLike) -> float | None:
    """Give 1 - SSE / SST: SSE about the line measured = reference, SST about the measured mean.

    None if all measured values are equal.
    """
    y, x = paired(measured, reference, 2)
    if spread(y) == 0:
        return None
    return 1 - float(((y - x) ** 2).sum() / ((y - y.mean()) ** 2).sum())
