"""From two cameras calibrated alone to a start for both: which pairs belong together, and how."""

from __future__ import annotations

import numpy as np

from simtip.calibrate.bundle import Fit
from simtip.calibrate.checks import require_order
from simtip.calibrate.outliers import VIEW_SHARE
from simtip.calibrate.problem import Unknowns
from simtip.calibrate.selection import Selection
from simtip.calibrate.stereo import Agreement, agree
from simtip.calibrate.symmetry import relabelled, symmetries
from simtip.errors import InputError
from simtip.geometry import Array, Pose


def brought_together(selection: Selection, alone: tuple[Fit, Fit], *, turnable: bool) -> Unknowns:
    """Find the relative pose, put numberings right, and take out pairs that disagree.

    Parameters
    ----------
    selection
        Views that do not fit are taken out of it, views numbered differently are put right in it.
    alone
        The left and the right camera, each from the views it saw.
    turnable
        Whether numberings may be put right; otherwise such views are taken out.

    Raises
    ------
    InputError
        Too few pairs agree, or left and right are swapped.
    """
    pairs = selection.pairs
    turns = symmetries(selection.points_mm)
    poses = [
        _poses(selection, camera, fit) for camera, fit in zip(("left", "right"), alone, strict=True)
    ]
    far = _far_points(selection.points_mm)
    agreement = agree(
        _stacked([poses[0][name] for name in pairs]),
        _stacked([poses[1][name] for name in pairs]),
        selection.points_mm[far],
        np.stack([selection.points_mm[np.argsort(order)[far]] for order in turns.values()]),
        float(alone[1].at.left[0]),
    )
    _require_agreement(agreement)
    require_order(agreement.T_lr.t)
    angles = list(turns)
    sightings = dict(zip(*selection.seen_by("right"), strict=True))
    for i, name in enumerate(pairs):
        angle = angles[agreement.numbering[i]]
        if not agreement.agrees[i]:
            selection.reject(name, _disagreement(agreement, i))
        elif angle and turnable:
            selection.turn_right(name, relabelled(sightings[name], turns[angle]))
        elif angle:
            selection.reject(
                name,
                f"left and right number the target's points differently, by a turn of {angle} "
                "degrees",
            )
    selection.require_pairs("alike by both cameras")
    boards = [
        poses[0][view.name] if view.name in poses[0] else agreement.T_lr @ poses[1][view.name]
        for view in selection.views
    ]
    turned, shifts = _stacked(boards)
    return Unknowns(
        alone[0].at.left, alone[1].at.left, agreement.T_lr.R, agreement.T_lr.t, turned, shifts
    )


def _poses(selection: Selection, camera: str, fit: Fit) -> dict[str, Pose]:
    names, _ = selection.seen_by(camera)
    return {name: Pose(R, t) for name, R, t in zip(names, fit.at.turns, fit.at.shifts, strict=True)}


def _stacked(poses: list[Pose]) -> tuple[Array, Array]:
    return np.stack([pose.R for pose in poses]), np.stack([pose.t for pose in poses])


def _far_points(points_mm: Array) -> list[int]:
    """Pick the points that lie furthest towards the four corners of the target."""
    x, y = points_mm[:, 0], points_mm[:, 1]
    return sorted({int(np.argmax(a * x + b * y)) for a in (-1, 1) for b in (-1, 1)})


def _require_agreement(agreement: Agreement) -> None:
    agreeing, pairs = int(agreement.agrees.sum()), len(agreement.agrees)
    if agreeing < max(2, (1 - VIEW_SHARE) * pairs):
        raise InputError(
            f"left and right agree about the board in only {agreeing} of {pairs} views",
            field="views",
            remedy="see that each left image is paired with the right image of the same instant",
        )


def _disagreement(agreement: Agreement, i: int) -> str:
    return (
        f"left and right see the board in places {agreement.off_mm[i]:.2g} mm "
        f"({agreement.off_px[i]:.0f} px) apart: it moved between the two exposures, is not the "
        "same view, or its points are numbered differently"
    )
