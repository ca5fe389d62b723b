"""Tries of one method on one condition, as figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from detector_trials import Look, Try

from simtip.bound import pooled_efficiency

Bound = Mapping[str, Any]
"""What ``simtip bound SCENE --json`` gives."""

WAYS = ("along", "across")


def figures(tried: Sequence[Try], bounds: Mapping[int, Bound] | None = None) -> dict[str, Any]:
    """Give what the table shows, and more.

    A tip counts as **right** if it lies within one width of the needle from the true one, and its
    errors are those of the right ones alone: a tip on something else has no bias. `false` counts
    tips seen in images that the true tip is not in. What cannot be said is None, as is what a
    method of both images would say of one.

    Parameters
    ----------
    tried
        All pairs of the condition.
    bounds
        By pose. Efficiency is that of the tries at these poses alone.
    """
    looks = [look for one in tried for look in one.looks]
    there = [look for look in looks if look.in_view]
    right = [look for look in there if is_right(look)]
    both = [one for one in tried if one.place is not None and _both_right(one)]
    alone = [] if any(one.of_both for one in tried) else right
    return {
        "pairs": len(tried),
        "images": len(there),
        "found": _share(sum(look.along_px is not None for look in there), len(there)),
        "right": _share(len(right), len(there)),
        "false": sum(look.along_px is not None for look in looks if not look.in_view),
        "empty": len(looks) - len(there),
        "statuses": dict(Counter(look.status for look in looks)),
        **_in_images(alone, bounds or {}),
        **_in_space(both, bounds or {}),
        "ms": float(np.median([one.time_s for one in tried])) * 1000,
    }


def is_right(look: Look) -> bool:
    """Say whether a tip was seen within one width of the needle from the true one."""
    if look.along_px is None or look.across_px is None:
        return False
    return bool(np.hypot(look.along_px, look.across_px) <= look.width_px)


def _both_right(one: Try) -> bool:
    return all(look.in_view and is_right(look) for look in one.looks)


def _in_images(right: Sequence[Look], bounds: Mapping[int, Bound]) -> dict[str, Any]:
    """Give the errors px, along and across."""
    px = np.array([(look.along_px, look.across_px) for look in right], float).reshape(-1, 2)
    groups = [(look.pose, look.side) for look in right]
    claims, variance = [look.claimed_px2 for look in right], _variance(groups, px)
    known = [
        (bounds[look.pose]["bound_px"][look.side], look) for look in right if look.pose in bounds
    ]
    efficiencies = {
        way: pooled_efficiency(
            [bound[way] for bound, _ in known], [getattr(look, f"{way}_px") for _, look in known]
        )
        for way in WAYS
    }
    return {
        "bias_px": _pair(px.mean(axis=0)) if len(px) else None,
        "rmse_px": _pair(_rms(px)) if len(px) else None,
        "scatter_px": None if variance is None else _pair(np.sqrt(variance)),
        "claimed_to_scatter": _claims(groups, px, claims),
        "efficiency_px": efficiencies if all(efficiencies.values()) else None,
    }


def _in_space(both: Sequence[Try], bounds: Mapping[int, Bound]) -> dict[str, Any]:
    """Give the errors mm, of pairs with both tips right; `across` is square to the axis."""
    places = [one.place for one in both if one.place is not None]
    poses = [one.looks[0].pose for one in both]
    norms = [place.norm_mm for place in places]
    errors = np.array([place.error_mm for place in places], float).reshape(-1, 3)
    known = [
        (bounds[pose]["bound_mm"]["norm"], norm)
        for pose, norm in zip(poses, norms, strict=True)
        if pose in bounds
    ]
    return {
        "pairs_right": len(norms),
        "mean_mm": float(np.mean(norms)) if norms else None,
        "rmse_mm": float(np.sqrt(np.mean(np.square(norms)))) if norms else None,
        "largest_mm": max(norms) if norms else None,
        "claimed_to_scatter_mm": _claims(poses, errors, [place.claimed_mm2 for place in places]),
        "efficiency_mm": pooled_efficiency([b for b, _ in known], [e for _, e in known]),
        "efficiency_poses": len({pose for pose in poses if pose in bounds}),
    }


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _pair(values: np.ndarray) -> dict[str, float]:
    return dict(zip(WAYS, map(float, values), strict=True))


def _rms(errors: np.ndarray) -> np.ndarray:
    return np.sqrt((errors**2).mean(axis=0))


def _variance(poses: Sequence[Hashable], errors: np.ndarray) -> np.ndarray | None:
    """Give the variance (2,) under fresh noise alone, about each pose's own mean.

    Parameters
    ----------
    poses
        (N,) what differs by noise alone has the same one; of one alone nothing is told.
    errors
        (N, D), the first along; all others together are the second figure.
    """
    groups = [errors[[other == pose for other in poses]] for pose in dict.fromkeys(poses)]
    groups = [group for group in groups if len(group) > 1]
    if not groups:
        return None
    squares = sum(((group - group.mean(axis=0)) ** 2).sum(axis=0) for group in groups)
    variances = np.asarray(squares) / sum(len(group) - 1 for group in groups)
    return np.array([variances[0], variances[1:].sum()])


def _claims(
    poses: Sequence[Hashable], errors: np.ndarray, claimed: Sequence[tuple[float, float] | None]
) -> dict[str, float] | None:
    """Give the claimed standard deviation over the scatter, of those that claim one."""
    claiming = [k for k, one in enumerate(claimed) if one is not None]
    variance = _variance([poses[k] for k in claiming], errors[claiming])
    if variance is None or not variance.all():
        return None
    return _pair(np.sqrt(np.mean([claimed[k] for k in claiming], axis=0) / variance))
