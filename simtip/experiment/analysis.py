"""From what was measured in an experiment to what it says of the measuring system."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from simtip.capability import (
    Accuracy,
    Agreement,
    Gauge,
    Repeatability,
    assess_accuracy,
    assess_agreement,
    assess_gauge,
    assess_repeatability,
    register,
    summarise_errors,
)
from simtip.capability.shared_runs import Layout, layout, limits_of, repeatability_of
from simtip.errors import InputError
from simtip.experiment.performed import Measured
from simtip.experiment.result import CAMERA, STAGE, Capability, Displacements, Frame, Position
from simtip.experiment.series import ACCURACY, REGISTRATION
from simtip.geometry import Array, unit
from simtip.spec.experiment import ExperimentSpec

LEAST = 3
"""Displacements that statistics take."""


SHARED_NOTE = (
    "displacements of one run share its start: intervals of bias, limits, sigma and P/T take runs "
    "and positions as random; those of correlation and concordance take pairs as independent"
)
INCOMPLETE_NOTE = (
    "not all positions were measured in two runs or more: intervals take displacements as "
    "independent, which they are not, and are too narrow"
)
HIDDEN_NOTE = (
    "no displacement differs from one run to the next: whole pixels, or no noise, may hide it"
)


def analyse(spec: ExperimentSpec, measured: Sequence[Measured], axes: Array) -> Capability:
    """Analyse an experiment.

    Parameters
    ----------
    spec
        The experiment.
    measured
        What was measured, by series, the scene's own set-up first.
    axes
        (3, 3) of the stage, world, as rows: what the registration ought to find.

    Raises
    ------
    InputError
        Too few tips were measured.
    """
    own = measured[0]
    left_out: dict[str, str] = {}
    first = slice(0, spec.schedule.accuracy_runs)
    single = next((part for part in measured if part.series.name == ACCURACY), None)
    steps = steps_of(own, first) if single is None else steps_of(single, slice(None))
    whole = from_start_of(own, slice(None))
    _refuse_too_few(own, whole)
    repeatability, of_errors = _repeatability(spec, own, whole, left_out)
    errors = _complete(own, own.series.laser_mm)
    agreement = assess_agreement(
        whole.measured,
        whole.reference,
        subjects=whole.position if errors is None else None,
        level=spec.level,
    )
    if errors is not None:
        shared = limits_of(agreement.limits, errors, spec.level)
        agreement = replace(agreement, limits=shared)
    return Capability(
        spec=spec,
        measured=measured,
        steps=steps,
        from_start=whole,
        accuracy=_accuracy(spec, steps, whole, left_out),
        accuracy_from_start=_from_start(spec, whole),
        agreement=agreement,
        agreement_repeated=_repeated(spec, whole),
        repeatability=repeatability,
        repeatability_of_errors=of_errors,
        grr=_gauge(spec, measured, left_out),
        position=_position(own, own.tip_mm - own.series.tip_mm, spec.level, CAMERA),
        frame=_frame(measured, axes, left_out, spec.level),
        left_out=left_out,
        notes=(
            SHARED_NOTE if errors is not None else INCOMPLETE_NOTE,
            *([HIDDEN_NOTE] if repeatability is not None and repeatability.sigma == 0 else []),
            *_missing_note(measured),
        ),
    )


def steps_of(part: Measured, runs: slice) -> Displacements:
    """Give displacements from each position to the next, where both were measured."""
    return _displacements(part, runs, part.tip_mm[:, :-1], part.series.laser_mm[:, :-1])


def from_start_of(part: Measured, runs: slice) -> Displacements:
    """Give displacements from each run's first position, where both were measured."""
    return _displacements(part, runs, part.tip_mm[:, :1], part.series.laser_mm[:, :1])


def _displacements(part: Measured, runs: slice, from_mm: Array, from_laser: Array) -> Displacements:
    moved = np.linalg.norm(part.tip_mm[:, 1:] - from_mm, axis=-1)[runs]
    reference = np.abs(part.series.laser_mm[:, 1:] - from_laser)[runs]
    run, position = np.nonzero(np.isfinite(moved))
    return Displacements(
        moved[run, position],
        reference[run, position],
        tuple(map(int, run)),
        tuple(int(k) + 1 for k in position),
    )


def _refuse_too_few(own: Measured, whole: Displacements) -> None:
    if len(whole.measured) >= LEAST:
        return
    status = Counter(str(one) for one in own.status[~own.ok])
    worst = ", ".join(f"{count} {name}" for name, count in status.most_common(3))
    raise InputError(
        f"{len(whole.measured)} displacements were measured, too few to analyse ({worst})",
        field="experiment",
        remedy="see its sweeps by `simtip results`, and try another threshold or light",
    )


def _complete(own: Measured, laser_mm: Array | None) -> Layout | None:
    """Give the layout of displacements from the start, of positions measured in all runs with one.

    With readings of the interferometer, it is that of the errors.
    """
    moved = np.linalg.norm(own.tip_mm[:, 1:] - own.tip_mm[:, :1], axis=-1)
    if laser_mm is not None:
        moved = moved - np.abs(laser_mm[:, 1:] - laser_mm[:, :1])
    runs = moved[own.ok[:, 0]]
    whole = runs[:, np.isfinite(runs).all(axis=0)]
    return layout(whole) if min(whole.shape) >= 2 else None


def _accuracy(
    spec: ExperimentSpec, steps: Displacements, whole: Displacements, left_out: dict[str, str]
) -> Accuracy | None:
    """Assess steps; how the bias runs with displacement is asked of those from the start."""
    if len(steps.measured) < 2:
        left_out["accuracy"] = "fewer than two steps were measured at both ends"
        return None
    found = assess_accuracy(
        steps.measured,
        steps.reference,
        steps=(steps.measured, steps.reference),
        cumulative=(whole.measured, whole.reference),
        level=spec.level,
    )
    return replace(found, linearity=_from_start(spec, whole).linearity)


def _from_start(spec: ExperimentSpec, whole: Displacements) -> Accuracy:
    return assess_accuracy(whole.measured, whole.reference, level=spec.level)


def _repeated(spec: ExperimentSpec, whole: Displacements) -> Agreement | None:
    if not 1 < len(set(whole.position)) < len(whole.position):
        return None
    return assess_agreement(
        whole.measured,
        whole.reference,
        subjects=whole.position,
        true_value="varies",
        level=spec.level,
    )


def _repeatability(
    spec: ExperimentSpec, own: Measured, whole: Displacements, left_out: dict[str, str]
) -> tuple[Repeatability | None, Repeatability | None]:
    if len(set(whole.position)) == len(whole.position):
        left_out["repeatability"] = "no displacement was measured twice"
        return None, None
    found = []
    for values, laser in (
        (whole.measured, None),
        (whole.measured - whole.reference, own.series.laser_mm),
    ):
        one = assess_repeatability(
            values,
            whole.position,
            tolerance=spec.tolerance_mm,
            multiplier=spec.multiplier,
            level=spec.level,
        )
        shared = _complete(own, laser)
        found.append(one if shared is None else repeatability_of(one, shared, spec.level))
    return found[0], found[1]


def _gauge(
    spec: ExperimentSpec, measured: Sequence[Measured], left_out: dict[str, str]
) -> Gauge | None:
    """Analyse positions along the first axis by place, set-up and run, of those seen everywhere.

    Not displacements: those of one run share its start, which would count as reproducibility.
    """
    parts = [part for part in measured if part.series.is_setup]
    if len(parts) < 2:
        left_out["grr"] = "the experiment has one set-up only: add some in experiment.setups"
        return None
    runs = spec.schedule.setup_runs
    along = positions_along(parts)
    study = np.stack([one[:runs] for one in along]).transpose(2, 0, 1)  # place, set-up, run
    whole = study[np.isfinite(study).all(axis=(1, 2))]
    if len(whole) < 2:
        left_out["grr"] = "fewer than two positions were measured in every run of every set-up"
        return None
    return assess_gauge(
        whole, tolerance=spec.tolerance_mm, multiplier=spec.multiplier, level=spec.level
    )


def positions_along(parts: Sequence[Measured]) -> list[Array]:
    """Give measured positions along the motion of the first of them, (runs, positions) each, mm."""
    places = np.nanmean(parts[0].tip_mm, axis=0)
    seen = places[np.isfinite(places).all(axis=1)]
    axis = unit(seen[-1] - seen[0])
    return [(part.tip_mm - seen[0]) @ axis for part in parts]


def _position(own: Measured, errors_mm: Array, level: float, frame: str) -> Position:
    """Sum up errors (runs, positions, 3); intervals are over positions, each counting once."""
    lengths = np.linalg.norm(errors_mm[own.ok], axis=1)
    at = errors_mm[:, own.ok.any(axis=0)]
    means = np.nanmean(at, axis=0)
    axes = {axis: summarise_errors(means[:, k], level) for k, axis in enumerate("xyz")}
    return Position(frame, axes, float(np.sqrt((lengths**2).mean())), float(lengths.max()))


def _frame(
    measured: Sequence[Measured], axes: Array, left_out: dict[str, str], level: float
) -> Frame | None:
    """Register the stage's frame: its own coordinates are those it was commanded to."""
    part = next((one for one in measured if one.series.name == REGISTRATION), None)
    if part is None:
        left_out["registration"] = "the experiment has none (schedule.registration)"
        return None
    try:
        found = register(part.tip_mm[part.ok], part.series.commanded_mm[part.ok])
    except ValueError as error:
        left_out["registration"] = str(error)
        return None
    own = measured[0]
    errors = found.apply(own.tip_mm) - own.series.stage_mm
    turn = found.R @ axes.T
    cosine = np.clip((np.trace(turn) - 1) / 2, -1, 1)
    return Frame(
        found,
        float(np.degrees(np.arccos(cosine))),
        _position(own, errors, level, STAGE),
        errors[own.ok].mean(axis=0),
    )


def _missing_note(measured: Sequence[Measured]) -> list[str]:
    missing = sum(int((~part.ok).sum()) for part in measured)
    return [f"{missing} measurements without a tip are left out"] if missing else []
