"""Efficiency: the bound over the error that was made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def efficiency(bound: float | None, rmse: float | None) -> float | None:
    """Give bound / RMSE: 1 is as good as unbiased measurement can be; bias counts against it.

    Parameters
    ----------
    bound, rmse
        In the same unit; None where there is none.

    Returns
    -------
    efficiency
        None where one is unknown or not finite, or the RMSE is 0.
    """
    if bound is None or rmse is None or not (np.isfinite(bound) and np.isfinite(rmse)):
        return None
    return float(bound / rmse) if rmse > 0 else None


def pooled_efficiency(
    bounds: Sequence[float | None], errors: Sequence[float | None]
) -> float | None:
    """Give the efficiency over many trials: root mean square of the bounds over that of the errors.

    Trials may be of different scenes, each with its own bound. Those without an error (no tip was
    measured) do not count.

    Parameters
    ----------
    bounds
        Of each trial's scene, e.g. `KnownBound.norm_mm`; None where the images do not determine it.
    errors
        Of each trial, signed or norms, in the same unit; None where nothing was measured.

    Returns
    -------
    efficiency
        None where no error is known, all are 0, or a bound that counts is unknown.

    Raises
    ------
    ValueError
        There are not as many bounds as errors.
    """
    both = [(b, e) for b, e in zip(bounds, errors, strict=True) if e is not None]
    known = [(b, e) for b, e in both if b is not None]
    if not known or len(known) < len(both):
        return None
    bound, rmse = np.sqrt(np.mean(np.square(known), axis=0))
    return efficiency(float(bound), float(rmse))
