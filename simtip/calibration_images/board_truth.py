"""What ``truth.json`` of `simtip boards` says of the images beside it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simtip.camera import StereoRig
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.json_file import read_json
from simtip.rig_file.own_json import rig_from_json
from simtip.target import Target, parse_target
from simtip.yaml_file import Document

REMEDY = "give the truth.json that `simtip boards` wrote"


@dataclass(frozen=True, eq=False)
class BoardTruth:
    """The truth of a set of calibration images.

    Attributes
    ----------
    file
        Where it stands.
    target
        What the boards show.
    rig
        What took the images.
    low_mm, high_mm
        (3,) corners of the working volume, left camera's frame.
    bow_mm, print_scale
        How the board differs from a flat, true print: its bow, and the scale along x and y.
    pixels
        (n, 2) of each image by its file's name: where all of the target's points are, px.
    """

    file: Path
    target: Target
    rig: StereoRig
    low_mm: Array
    high_mm: Array
    bow_mm: float
    print_scale: tuple[float, float]
    pixels: dict[str, Array]

    def of(self, image: Path) -> Array:
        """Give where the points are in an image.

        Raises
        ------
        InputError
            The truth does not know it.
        """
        if image.name not in self.pixels:
            raise InputError(f"says nothing of {image.name}", file=self.file, remedy=REMEDY)
        return self.pixels[image.name]

    def require(self, target: Target) -> None:
        """Refuse a target of other points than the boards': their numbers would not agree.

        The length of a step may differ, as that of a board does whose owner measured it wrongly.

        Raises
        ------
        InputError
            It has.
        """
        same = type(target) is type(self.target)
        if not same or not np.array_equal(target.lattice, self.target.lattice):
            raise InputError(
                f"is {target}, and {self.file} is of {self.target}",
                field="--target",
                remedy="give the target that is in the images",
            )


def read_board_truth(path: str | Path) -> BoardTruth:
    """Read the truth of a set of calibration images.

    Raises
    ------
    InputError
        The file is missing or something in it is, or is not of its kind.
    """
    file = Path(path)
    value = read_json(file, REMEDY)
    target = _target(file, value)
    count = len(target.points)
    volume = _child(file, value, "working_volume_mm", dict)
    plate = _child(file, value, "plate", dict)
    scale = _numbers(file, plate, "plate.print_scale", (2,))
    rig = rig_from_json(Document(str(file), _child(file, value, "rig", dict), {}))
    pixels: dict[str, Array] = {}
    for k, view in enumerate(_child(file, value, "views", list)):
        for side in ("left", "right"):
            field = f"views[{k}].{side}"
            image = _child(file, view if isinstance(view, dict) else {}, field, dict)
            name = _child(file, image, f"{field}.file", str)
            pixels[name] = _numbers(file, image, f"{field}.points_px", (count, 2))
    return BoardTruth(
        file=file,
        target=target,
        rig=rig,
        low_mm=_numbers(file, volume, "working_volume_mm.low", (3,)),
        high_mm=_numbers(file, volume, "working_volume_mm.high", (3,)),
        bow_mm=float(_numbers(file, plate, "plate.bow_mm", ())),
        print_scale=(float(scale[0]), float(scale[1])),
        pixels=pixels,
    )


def _child(file: Path, parent: dict[str, Any], field: str, kind: type) -> Any:
    """Give the value whose name is the last part of a field's."""
    value = parent.get(field.rpartition(".")[2])
    if not isinstance(value, kind):
        problem = "is missing" if value is None else f"is no {kind.__name__}"
        raise InputError(problem, file=file, field=field, remedy=REMEDY)
    return value


def _target(file: Path, value: dict[str, Any]) -> Target:
    try:
        return parse_target(_child(file, value, "target", str))
    except InputError as error:
        raise InputError(error.problem, file=file, field="target", remedy=REMEDY) from error


def _numbers(file: Path, parent: dict[str, Any], field: str, shape: tuple[int, ...]) -> Array:
    try:
        found = np.array(parent.get(field.rpartition(".")[2]), dtype=np.float64)
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    if found.shape != shape or not np.isfinite(found).all():
        size = " x ".join(map(str, shape)) or "1"
        raise InputError(f"is not {size} finite numbers", file=file, field=field, remedy=REMEDY)
    return found
