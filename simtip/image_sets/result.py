"""A folder of `simtip run`, `render` or `remix`: one pair, checked against its manifest."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.image_sets.images import read_taken
from simtip.image_sets.pairs import SIDES, NeedlePair, Reading
from simtip.input_file import read_bytes
from simtip.json_file import read_json
from simtip.scene_file import load_scene
from simtip.truth import SceneTruth, scene_truth

MANIFEST, TRUTH, SCENE, RESULT = "manifest.json", "truth.json", "scene.yaml", "result.json"

MAX_BYTES = 1 << 30

AGREE = 1e-6
"""How far what is true of the scene may be from ``truth.json``, mm or px."""

RESTORE = "restore it, or make the folder anew from its scene.yaml"


class ResultImages:
    """A folder that holds one pair.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    InputError
        A file is missing, cut short, or not as it was written.
    """

    settings: tuple[str, ...] = ()
    without_images: Mapping[str, int] = {}

    def __init__(self, folder: Path) -> None:
        self.source = str(folder)
        self._folder = folder
        listed = _listed(folder)
        measured = (RESULT,) if RESULT in listed else ()
        for name in (*(f"{side}.png" for side in SIDES), TRUTH, SCENE, *measured):
            _require_as_written(folder / name, listed)
        self._spec = load_scene(folder / SCENE)
        self._truth = scene_truth(self._spec)
        _require_agreement(folder, self._truth)
        self._readings = tuple(self._reading(folder / name) for name in measured)

    def __len__(self) -> int:
        """Give 1."""
        return 1

    def pairs(self) -> Iterator[NeedlePair]:
        """Give it."""
        rig = self._truth.rig
        left, right = (
            read_taken(self._folder / f"{side}.png", camera, RESTORE)
            for side, camera in zip(SIDES, (rig.left, rig.right), strict=True)
        )
        yield NeedlePair(self.source, "", self._spec, self._truth, (left, right), self._readings)

    def _reading(self, file: Path) -> Reading:
        found = read_json(file, RESTORE)
        try:
            tips = found["tip_detected_px"]
            left, right = (_numbers(tips[side], 2) for side in SIDES)
            return Reading(
                detector=str(found["detector"]),
                status=str(found["status"]),
                reason=str(found["reason"]),
                tips_px=(left, right),
                tip_mm=_numbers(found["tip_measured_mm"], 3),
                spec=self._spec,
            )
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise InputError(f"is no result ({error})", file=file, remedy=RESTORE) from error


def _numbers(values: Any, count: int) -> Array | None:
    if values is None:
        return None
    found = np.array(values, dtype=np.float64)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise ValueError(f"{values!r} is not {count} numbers"[:80])
    return found


def _listed(folder: Path) -> dict[str, str]:
    """Read which files a folder had when it was written, with their SHA-256."""
    found = read_json(folder / MANIFEST, RESTORE).get("sha256")
    if not isinstance(found, dict) or not all(isinstance(one, str) for one in found.values()):
        raise InputError("lists no files", file=folder / MANIFEST, field="sha256", remedy=RESTORE)
    return found


def _require_as_written(file: Path, listed: Mapping[str, str]) -> None:
    if file.name not in listed:
        raise InputError(f"does not list {file.name}", file=file.parent / MANIFEST, remedy=RESTORE)
    if not file.exists():
        raise InputError(f"is missing, and {MANIFEST} lists it", file=file, remedy=RESTORE)
    if hashlib.sha256(read_bytes(file, MAX_BYTES)).hexdigest() != listed[file.name]:
        raise InputError(
            f"has been changed since it was written: its SHA-256 is not that in {MANIFEST}",
            file=file,
            remedy=RESTORE,
        )


def _require_agreement(folder: Path, truth: SceneTruth) -> None:
    """Refuse a folder whose truth is not what this simtip finds of its scene."""
    file = folder / TRUTH
    found = read_json(file, RESTORE)
    try:
        pairs = [(found["tip_mm"], truth.tip_mm), (found["axis"], truth.axis)]
        pairs += [
            (found[side]["tip_px"], view.tip_px)
            for side, view in zip(SIDES, (truth.left, truth.right), strict=True)
        ]
        off = max(float(np.abs(np.array(told) - true).max()) for told, true in pairs)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"is no truth of a needle ({error})", file=file, remedy=RESTORE) from error
    if not off <= AGREE:
        raise InputError(
            f"differs by {off:.3g} from what this simtip finds of {SCENE}",
            file=file,
            remedy="use the simtip that wrote it, or make the folder anew from its scene.yaml",
        )
