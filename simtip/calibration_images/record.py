"""What the pictures of a calibration show, and what of it lies in a folder."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simtip.calibrate import ErrorMap
from simtip.calibrate.calibration import Reprojection
from simtip.calibrate.corners import Corners
from simtip.calibration_images.look import Size
from simtip.calibration_images.outcome import Outcome
from simtip.errors import InputError
from simtip.geometry import Array, Pose
from simtip.input_file import read_bytes

RESULT, POINTS = "calibration.json", "points.json"
MAX_BYTES = 1 << 28


@dataclass(frozen=True, eq=False)
class Record:
    """Every point of a calibration, and what the error does in space.

    Attributes
    ----------
    views
        Names of those used.
    sizes
        (width, height) of the left and of the right images, px.
    left, right
        The points and their residuals.
    raw_px, eight_point_px, rig_px
        (n,) distances of right points from epipolar lines, px: by the eight-point F of images as
        they are, by that of undistorted points, and by the rig.
    error_map
        Where the truth is known.
    """

    views: tuple[str, ...]
    sizes: tuple[Size, Size]
    left: Reprojection
    right: Reprojection
    raw_px: Array
    eight_point_px: Array
    rig_px: Array
    error_map: ErrorMap | None

    @classmethod
    def of(cls, outcome: Outcome) -> Record:
        """Take it from a calibration just made."""
        made, judged = outcome.calibration, outcome.judgement
        rig = made.rig
        return cls(
            made.views_used,
            ((rig.left.width, rig.left.height), (rig.right.width, rig.right.height)),
            made.left,
            made.right,
            made.epipolar_raw.right_px,
            made.epipolar.right_px,
            made.epipolar_rig.right_px,
            None if judged is None else judged.error_map,
        )

    def to_dict(self) -> dict[str, Any]:
        """Give plain values, for JSON."""
        told: dict[str, Any] = {
            "views": list(self.views),
            "image_size": {"left": list(self.sizes[0]), "right": list(self.sizes[1])},
            "left": _points(self.left),
            "right": _points(self.right),
            "epipolar_px": {
                "raw": self.raw_px.tolist(),
                "eight_point": self.eight_point_px.tolist(),
                "rig": self.rig_px.tolist(),
            },
            "error_map": None,
        }
        found = self.error_map
        if found is not None:
            told["error_map"] = {
                "points_mm": found.points_mm.tolist(),
                "displacement_mm": found.displacement_mm.tolist(),
                "rigid": {"R": found.rigid.R.tolist(), "t_mm": found.rigid.t.tolist()},
                "deformation_mm": found.deformation_mm.tolist(),
                "step_mm": found.step_mm,
                "step_error_mm": found.step_error_mm.tolist(),
                "left_out": found.left_out,
                "failed": found.failed,
            }
        return told


def _points(of: Reprojection) -> dict[str, Any]:
    return {
        "view": of.corners.view.tolist(),
        "id": of.corners.ids.tolist(),
        "target_mm": of.corners.points_mm.tolist(),
        "seen_px": of.corners.pixels.tolist(),
        "residual_px": of.residual_px.tolist(),
    }


def write_record(folder: Path, outcome: Outcome) -> None:
    """Write a calibration's result and points into a folder."""
    for name, data in ((RESULT, outcome.to_dict()), (POINTS, Record.of(outcome).to_dict())):
        text = json.dumps(data, allow_nan=False, indent=1 if name == RESULT else None)
        (folder / name).write_text(text + "\n", encoding="utf-8")


def read_record(folder: Path) -> Record:
    """Read the points back.

    Raises
    ------
    InputError
        They are missing, damaged or cut short.
    """
    file = folder / POINTS
    try:
        told = json.loads(read_bytes(file, MAX_BYTES))
        sizes = tuple(_size(*told["image_size"][side]) for side in SIDES)
        distances = told["epipolar_px"]
        record = Record(
            tuple(map(str, told["views"])),
            (sizes[0], sizes[1]),
            _reprojection(told["left"]),
            _reprojection(told["right"]),
            _array(distances["raw"], 1),
            _array(distances["eight_point"], 1),
            _array(distances["rig"], 1),
            None if told["error_map"] is None else _error_map(told["error_map"]),
        )
        _require_views(record)
    except InputError:
        raise
    except (ValueError, TypeError, LookupError, ArithmeticError, RecursionError) as error:
        raise InputError(
            "is damaged or cut short", file=file, remedy="calibrate again into a new folder"
        ) from error
    return record


SIDES = ("left", "right")
LARGEST = 1e6
"""Pixels and mm; what is larger is no camera's, and no figure could show it."""


def _size(width: Any, height: Any) -> tuple[int, int]:
    size = int(width), int(height)
    if not 1 <= min(size) <= max(size) <= LARGEST:
        raise ValueError("no size of an image")
    return size


def _array(values: Any, columns: int) -> Array:
    array = np.asarray(values, dtype=np.float64)
    wanted = array.ndim == 1 if columns == 1 else array.ndim == 2 and array.shape[1] == columns
    if not wanted or not len(array) or not (np.abs(array) <= LARGEST).all():
        raise ValueError(f"no points of {columns} numbers")
    return array


def _reprojection(told: dict[str, Any]) -> Reprojection:
    view, ids = (np.asarray(told[name], dtype=np.intp) for name in ("view", "id"))
    corners = Corners(view, ids, _array(told["target_mm"], 3), _array(told["seen_px"], 2))
    residual = _array(told["residual_px"], 2)
    if not len(view) == len(ids) == len(corners.pixels) == len(residual):
        raise ValueError("lengths differ")
    return Reprojection(corners, residual)


def _error_map(told: dict[str, Any]) -> ErrorMap:
    arrays = [
        _array(told[name], 3)
        for name in ("points_mm", "displacement_mm", "deformation_mm", "step_error_mm")
    ]
    if len({len(array) for array in arrays}) > 1:
        raise ValueError("lengths differ")
    rigid = Pose(_array(told["rigid"]["R"], 3), _array(told["rigid"]["t_mm"], 1))
    return ErrorMap(
        points_mm=arrays[0],
        displacement_mm=arrays[1],
        rigid=rigid,
        deformation_mm=arrays[2],
        step_mm=float(told["step_mm"]),
        step_error_mm=arrays[3],
        left_out=int(told["left_out"]),
        failed=int(told["failed"]),
    )


def _require_views(record: Record) -> None:
    for of in (record.left, record.right):
        view = of.corners.view
        if view.min() < 0 or view.max() >= len(record.views):
            raise ValueError("a point is of no view")
