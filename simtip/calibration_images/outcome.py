"""Images in, a calibrated rig out, with all that is known of it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from simtip.calibrate import (
    Calibration,
    Comparison,
    ErrorMap,
    LensModel,
    Rejected,
    calibrate,
    compare,
    error_map,
)
from simtip.calibration_images.board_truth import BoardTruth
from simtip.calibration_images.corner_error import CornerError, corner_error
from simtip.calibration_images.look import Looked, Report, Size, look_at
from simtip.calibration_images.names import side_of
from simtip.calibration_images.pairs import Pairs, find_pairs
from simtip.errors import InputError
from simtip.target import Target


@dataclass(frozen=True, eq=False)
class Judgement:
    """A calibration held against the truth.

    Attributes
    ----------
    truth
        What is true.
    comparison
        Every parameter.
    error_map
        What the errors do in the working volume.
    corners
        Errors of the points found.
    """

    truth: BoardTruth
    comparison: Comparison
    error_map: ErrorMap
    corners: CornerError


@dataclass(frozen=True, eq=False)
class Outcome:
    """A calibration from image files.

    Attributes
    ----------
    images
        As they were named.
    target
        What was looked for.
    sizes
        (width, height) of the left and of the right images, px.
    calibration
        The rig, and how good it is.
    rejected
        All views left out, with reasons: images alone, those without a target, those that do not
        fit the others.
    judgement
        If the truth is known.
    warnings
        The calibration's, and of the truth.
    timings_s
        Seconds of each stage.
    """

    images: str
    target: Target
    sizes: tuple[Size, Size]
    calibration: Calibration
    rejected: tuple[Rejected, ...]
    judgement: Judgement | None
    warnings: tuple[str, ...]
    timings_s: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Give all of it as plain values, for JSON."""
        result = {
            "images": self.images,
            "target": str(self.target),
            "image_size": {"left": list(self.sizes[0]), "right": list(self.sizes[1])},
            **self.calibration.to_dict(),
            "views_rejected": [{"view": r.view, "reason": r.reason} for r in self.rejected],
            "warnings": list(self.warnings),
        }
        if self.judgement is not None:
            result |= {
                "truth": str(self.judgement.truth.file),
                "error": self.judgement.comparison.to_dict(),
                "error_at_needle_mm": self.judgement.error_map.summary(),
                "corner_error_px": self.judgement.corners.to_dict(),
            }
        return {**result, "timings_s": self.timings_s}


def calibrate_images(
    images: Sequence[str],
    target: Target,
    *,
    model: str = LensModel.OPENCV5,
    truth: BoardTruth | None = None,
    report: Report | None = None,
) -> Outcome:
    """Calibrate a stereo rig from image files.

    The target is taken as it is named: that the truth's board is bowed or printed too large is
    not told to the calibration.

    Parameters
    ----------
    images
        A folder, or a pattern for each camera; see `find_pairs`.
    target
        What they show.
    model
        Of the distortion: ``none``, ``radial2``, ``radtan``, ``opencv5``, ``rational`` or ``auto``.
    truth
        Of the images, if known.
    report
        Called with the fraction of the search done.

    Raises
    ------
    InputError
        The images, or what they show, are no material for a calibration.
    """
    started = time.perf_counter()
    found = find_pairs(images)
    if truth is not None:
        truth.require(target)
        for pair in found.pairs:
            truth.of(pair.left)
            truth.of(pair.right)
    looked = look_at(found.pairs, target, report)
    searched = time.perf_counter()
    try:
        calibration = calibrate(
            looked.views,
            target.points,
            *looked.sizes,
            model=model,
            turnable=target.half_turn_ambiguous or target.quarter_turn_ambiguous,
        )
    except InputError as error:
        raise _located(error, " ".join(images), looked) from error
    done = time.perf_counter()
    judgement = None if truth is None else _judged(calibration, looked, truth, target)
    return Outcome(
        images=" ".join(images),
        target=target,
        sizes=looked.sizes,
        calibration=calibration,
        rejected=(*_alone(found), *looked.skipped, *calibration.views_rejected),
        judgement=judgement,
        warnings=(*calibration.warnings, *_warnings(looked, target, judgement)),
        timings_s={"find": searched - started, "calibrate": done - searched},
    )


def _located(error: InputError, images: str, looked: Looked) -> InputError:
    """Name the images, and say what else was left out: too few views often are skipped ones."""
    problem = error.problem
    if looked.skipped:
        first = looked.skipped[0]
        problem += f" ({len(looked.skipped)} views without target, first {first.view})"
    return InputError(problem, file=images, field=error.field, remedy=error.remedy)


def _alone(found: Pairs) -> list[Rejected]:
    rejected = []
    for file in found.unpaired:
        other = {"left": "right", "right": "left"}.get(side_of(file.stem) or "", "other")
        rejected.append(Rejected(file.stem, f"{file.name} has no {other} image"))
    return rejected


def _judged(
    calibration: Calibration, looked: Looked, truth: BoardTruth, target: Target
) -> Judgement:
    try:
        comparison = compare(calibration, truth.rig)
        costs = error_map(truth.rig, calibration.rig, truth.low_mm, truth.high_mm)
    except InputError as error:
        raise InputError(
            error.problem, file=truth.file, field=error.field, remedy=error.remedy
        ) from error
    return Judgement(
        truth, comparison, costs, corner_error(looked.views, looked.pairs, truth, target)
    )


def _warnings(looked: Looked, target: Target, judgement: Judgement | None) -> list[str]:
    warnings = []
    if looked.overexposed:
        warnings.append(
            f"{len(looked.overexposed)} images are overexposed, the first is "
            f"{looked.overexposed[0].name}: white that is cut off moves edges, expose for less"
        )
    if judgement is not None:
        if target != judgement.truth.target:
            warnings.append(f"the boards show {judgement.truth.target}, not {target}")
        costs = judgement.error_map
        out, seen = costs.left_out + costs.failed, len(costs.points_mm)
        if out > seen:
            warnings.append(
                f"{out} of {out + seen} points of the working volume are not in both images: the "
                "error at the needle is that of a small part"
            )
    return warnings
