"""A trial's row of the table, and the part of it that a measurement leaves in the cache."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simtip.geometry import Array
from simtip.measure import Measurement
from simtip.score import PixelError, TipError, point_error
from simtip.sweep.plan import Trial
from simtip.truth import SceneTruth

if TYPE_CHECKING:
    from simtip.sweep.stages import Setting

Row = dict[str, object]

MOST_REASON = 500
"""Characters of a reason."""


def record_of(
    measurement: Measurement, error: TipError, truth: SceneTruth, exposure_s: float
) -> Row:
    """Give what a table says of a measurement; all of it plain data."""
    point, refinement = error.point, measurement.refinement
    refined = None if refinement is None or not refinement.ok else refinement.tip_mm
    off = point_error(refined, truth.tip_mm)
    record: Row = {
        "status": measurement.status,
        "reason": measurement.reason[:MOST_REASON],
        "error_x_mm": point and point.x_mm,
        "error_y_mm": point and point.y_mm,
        "error_z_mm": point and point.z_mm,
        "error_norm_mm": point and point.norm_mm,
        "refined_norm_mm": off and off.norm_mm,
        **_pixels("left", error.left),
        **_pixels("right", error.right),
        **_place(measurement.tip_mm),
        "exposure_s": exposure_s,
        "detect_s": measurement.timings_s.get("detect"),
    }
    return record


@dataclass(frozen=True)
class Form:
    """What all rows of a sweep share.

    Attributes
    ----------
    kinds
        Of the factors' columns.
    code
        That they are made by, see `simtip.sweep.stage_keys.code_digest`.
    """

    kinds: Mapping[str, str]
    code: str


def row_of(trial: Trial, key: str, setting: Setting, record: Row, form: Form) -> Row:
    """Give a trial's row."""
    return {
        **_heading(trial, key, form),
        "noise_seed": setting.seed,
        **record,
        "light_key": setting.light,
        "image_key": setting.images,
    }


def failed(trial: Trial, key: str, status: str, reason: str, form: Form) -> Row:
    """Give the row of a trial that could not be worked out."""
    return {**_heading(trial, key, form), "status": status, "reason": reason[:MOST_REASON]}


def _heading(trial: Trial, key: str, form: Form) -> Row:
    return {
        "key": key,
        "trial": trial.number,
        "repeat": trial.repeat,
        "detector": trial.measuring.label,
        "code": form.code,
        **factor_cells(trial, form.kinds),
    }


def factor_cells(trial: Trial, kinds: Mapping[str, str]) -> Row:
    """Give a trial's values of the factors as cells of columns of these kinds."""
    return {path: cell_of(value, kinds[path]) for path, value in trial.factors.items()}


def cell_of(value: Any, kind: str) -> object:
    """Give a factor's value as a cell: parts and lists as text."""
    if value is None or (kind != "text" and isinstance(value, bool | int | float)):
        return float(value) if kind == "float" and value is not None else value
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True)


def _pixels(side: str, error: PixelError | None) -> Row:
    return {
        f"{side}_error_u_px": error and error.u_px,
        f"{side}_error_v_px": error and error.v_px,
        f"{side}_error_along_px": error and error.along_px,
        f"{side}_error_across_px": error and error.across_px,
    }


def _place(tip_mm: Array | None) -> Row:
    places = [None] * 3 if tip_mm is None else [float(x) for x in tip_mm]
    return {f"tip_{axis}_mm": place for axis, place in zip("xyz", places, strict=True)}
