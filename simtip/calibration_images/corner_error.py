"""How far the points of a target were found from where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.calibrate import View
from simtip.calibrate.symmetry import relabelled, symmetries
from simtip.calibration_images.board_truth import BoardTruth
from simtip.calibration_images.pairs import Pair
from simtip.geometry import Array
from simtip.target import Sighting, Target

CAMERAS = "left", "right"


@dataclass(frozen=True, eq=False)
class CornerError:
    """Errors of the finder; error = found - true, px of the image as it is.

    Attributes
    ----------
    views
        Names.
    left, right
        (n, 2) for each view, u and v.
    """

    views: tuple[str, ...]
    left: tuple[Array, ...]
    right: tuple[Array, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give bias, standard deviation and largest length: in all, per camera, per view."""
        sides = zip(self.views, self.left, self.right, strict=True)
        return {
            **_summary(np.concatenate([*self.left, *self.right])),
            "left": _summary(np.concatenate(self.left)),
            "right": _summary(np.concatenate(self.right)),
            "per_view": [
                {"view": name, "left": _summary(left), "right": _summary(right)}
                for name, left, right in sides
            ],
        }


def corner_error(
    views: Sequence[View], pairs: Sequence[Pair], truth: BoardTruth, target: Target
) -> CornerError:
    """Compare what was found with the truth.

    A target that looks the same from another end may be numbered from there; of the readings that
    it allows, the nearest to the truth counts.

    Parameters
    ----------
    views
        What was seen, by both cameras.
    pairs
        The views' files, whose names the truth knows.
    truth
        Where the points are.
    target
        What was looked for.

    Raises
    ------
    InputError
        The truth does not know a file.
    """
    errors: dict[str, list[Array]] = {"left": [], "right": []}
    for view, pair in zip(views, pairs, strict=True):
        for camera, sighting, file in zip(
            CAMERAS, (view.left, view.right), (pair.left, pair.right), strict=True
        ):
            true = truth.of(file)
            found = np.zeros((0, 2)) if sighting is None else _nearest(sighting, true, target)
            errors[camera].append(found)
    names = tuple(view.name for view in views)
    return CornerError(names, tuple(errors["left"]), tuple(errors["right"]))


def _nearest(sighting: Sighting, true: Array, target: Target) -> Array:
    readings = [sighting]
    if target.half_turn_ambiguous or target.quarter_turn_ambiguous:
        readings = [relabelled(sighting, turn) for turn in symmetries(target.points).values()]
    errors = [reading.pixels - true[reading.ids] for reading in readings]
    return min(errors, key=lambda e: float((e**2).sum()))


def _summary(error: Array) -> dict[str, Any]:
    lengths = np.linalg.norm(error, axis=1)
    return {
        "points": len(error),
        "bias": error.mean(axis=0).tolist(),
        "sd": error.std(axis=0).tolist(),
        "rms": float(np.sqrt((lengths**2).mean())),
        "max": float(lengths.max()),
    }
