"""Tries of one method on one condition, as figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from detector_trials import Look, Try

Bound = Mapping[str, Any]
"""What ``simtip bound SCENE --json`` gives."""


def figures(tried: Sequence[Try], bound: Bound | None = None) -> dict[str, Any]:
    """Give what the table shows, and more.

    A tip counts as **right** if it lies within one width of the needle from the true one, and its
    errors are those of the right ones alone: a tip on something else has no bias. `false` counts
    tips seen in images that the true tip is not in. What cannot be said is None.
    """
    looks = [look for one in tried for look in one.looks]
    there = [look for look in looks if look.in_view]
    right = [look for look in there if is_right(look)]
    both = [one.error_mm for one in tried if one.error_mm is not None and _both_right(one)]
    px = _errors(right)
    return {
        "pairs": len(tried),
        "images": len(there),
        "found": _share(sum(look.along_px is not None for look in there), len(there)),
        "right": _share(len(right), len(there)),
        "false": sum(look.along_px is not None for look in looks if not look.in_view),
        "empty": len(looks) - len(there),
        "statuses": dict(Counter(look.status for look in looks)),
        "bias_px": _pair(px.mean(axis=0)) if len(px) else None,
        "rmse_px": _pair(_rms(px)) if len(px) else None,
        "scatter_px": _pair(scatter) if (scatter := _scatter(right)) is not None else None,
        "claimed_to_scatter": _claims(right),
        "pairs_right": len(both),
        "mean_mm": float(np.mean(both)) if both else None,
        "rmse_mm": float(np.sqrt(np.mean(np.square(both)))) if both else None,
        "largest_mm": max(both) if both else None,
        "ms": float(np.median([one.time_s for one in tried])) * 1000,
        **_efficiency(px, both, bound),
    }


def is_right(look: Look) -> bool:
    """Say whether a tip was seen within one width of the needle from the true one."""
    if look.along_px is None or look.across_px is None:
        return False
    return bool(np.hypot(look.along_px, look.across_px) <= look.width_px)


def _both_right(one: Try) -> bool:
    return all(look.in_view and is_right(look) for look in one.looks)


def _errors(looks: Sequence[Look]) -> np.ndarray:
    return np.array([(look.along_px, look.across_px) for look in looks], float).reshape(-1, 2)


def _rms(px: np.ndarray) -> np.ndarray:
    return np.sqrt((px**2).mean(axis=0))


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _pair(values: np.ndarray) -> dict[str, float]:
    return {"along": float(values[0]), "across": float(values[1])}


def _by_pose(looks: Sequence[Look]) -> list[list[Look]]:
    """Group what differs by noise alone; a group of one tells nothing."""
    poses = sorted({look.pose for look in looks})
    groups = [[look for look in looks if look.pose == pose] for pose in poses]
    return [group for group in groups if len(group) > 1]


def _scatter(looks: Sequence[Look]) -> np.ndarray | None:
    """Give the standard deviation under fresh noise alone, about each pose's own mean."""
    groups = [_errors(group) for group in _by_pose(looks)]
    if not groups:
        return None
    squares = sum(((px - px.mean(axis=0)) ** 2).sum(axis=0) for px in groups)
    freedom = sum(len(px) - 1 for px in groups)
    return np.sqrt(np.asarray(squares) / freedom)


def _claims(looks: Sequence[Look]) -> dict[str, float] | None:
    """Give the claimed standard deviation over the scatter, of those that claim one."""
    claiming = [look for look in looks if look.claimed_px2 is not None]
    scatter = _scatter(claiming)
    if scatter is None or not scatter.all():
        return None
    claimed = np.sqrt(np.mean([look.claimed_px2 for look in claiming], axis=0))
    return _pair(claimed / scatter)


def _efficiency(px: np.ndarray, both: Sequence[float], bound: Bound | None) -> dict[str, Any]:
    """Give bound / RMSE in the image, along and across, and in space, nuisances free."""
    if bound is None:
        return {"efficiency_px": None, "efficiency_mm": None}
    views = [
        [bound["bound_px"][side][way] for way in ("along", "across")] for side in ("left", "right")
    ]
    least = _rms(np.array(views, float))
    in_space = np.sqrt(np.mean(np.square(both))) if both else None
    return {
        "efficiency_px": _pair(least / _rms(px)) if len(px) and _rms(px).all() else None,
        "efficiency_mm": bound["bound_mm"]["norm"] / float(in_space) if in_space else None,
    }
