"""COCO's annotations: keypoints, masks and boxes in ``annotations.json``, images beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.export.coco_file import CocoFile
from simtip.export.eight_bit import eight_bit
from simtip.export.keypoints import ABSENT, NAMES, SEEN, MarkedView, marked
from simtip.export.sources import source_rows
from simtip.export.tracer import Tracer
from simtip.geometry import Array
from simtip.image_file import write_png
from simtip.image_sets import BoardImages, BoardPair, NeedleImages, NeedlePair
from simtip.image_sets.pairs import SIDES
from simtip.render import Backend
from simtip.target import Target

Mask = NDArray[np.bool_]

IMAGES = "images"

NEEDLE = {
    "id": 1,
    "name": "needle",
    "supercategory": "instrument",
    "keypoints": list(NAMES),
    "skeleton": [[1, 2]],
}


def write_needles(
    folder: Path, sets: Sequence[NeedleImages], *, backend: Backend, done: Callable[[], None]
) -> None:
    """Write pairs of images of needles with keypoints, masks and boxes.

    Parameters
    ----------
    folder
        An empty one.
    sets
        Where the pairs are.
    backend
        What traces masks.
    done
        Called after each pair.

    Raises
    ------
    InputError
        A pair cannot be read.
    """
    with ExitStack() as opened:
        out = _Images(folder, opened)
        out.file.category(NEEDLE)
        tracer = Tracer(backend)
        for pair in (pair for one in sets for pair in one.pairs()):
            views = marked(pair, tracer)
            names = out.add(pair, pair.spec.sensor.bit_depth)
            for number, view in zip(names, views, strict=True):
                if view.surfaces.needle.any():
                    out.file.annotation(needle_annotation(view) | {"image_id": number})
            done()


def write_boards(folder: Path, sets: Sequence[BoardImages], *, done: Callable[[], None]) -> None:
    """Write pairs of images of calibration boards with their points as keypoints.

    Parameters and errors are those of `write_needles`.
    """
    with ExitStack() as opened:
        out = _Images(folder, opened)
        known: dict[str, int] = {}
        for pair in (pair for one in sets for pair in one.pairs()):
            target = str(pair.target)
            if target not in known:
                known[target] = len(known) + 1
                out.file.category(board_category(known[target], pair.target))
            names = out.add(pair, pair.bit_depth)
            for number, told in zip(names, board_annotations(pair, known[target]), strict=True):
                if told["num_keypoints"]:
                    out.file.annotation(told | {"image_id": number})
            done()


class _Images:
    """Writes and numbers the images."""

    def __init__(self, folder: Path, opened: ExitStack) -> None:
        self._folder = folder / IMAGES
        self._folder.mkdir()
        self.file = opened.enter_context(CocoFile(folder / "annotations.json"))
        self._sources = opened.enter_context(source_rows(folder))
        self._pairs = 0

    def add(self, pair: NeedlePair | BoardPair, bit_depth: int) -> tuple[int, int]:
        """Write both images of a pair, and give their ids."""
        files = [f"{self._pairs:06d}_{side}.png" for side in SIDES]
        numbers = 2 * self._pairs + 1, 2 * self._pairs + 2
        for number, name, image in zip(numbers, files, pair.images, strict=True):
            write_png(self._folder / name, eight_bit(image, bit_depth))
            height, width = image.shape[:2]
            self.file.image({"id": number, "file_name": name, "width": width, "height": height})
        left, right = (f"{IMAGES}/{name}" for name in files)
        named = {"source": pair.source, "label": pair.label}
        self._sources.add({"left": left, "right": right, **named})
        self._pairs += 1
        return numbers


def needle_annotation(view: MarkedView) -> dict[str, Any]:
    """Give the annotation of a needle that is seen, without its ids."""
    mask = view.surfaces.needle
    return {
        "category_id": 1,
        "iscrowd": 0,
        "segmentation": run_lengths(mask),
        "area": int(mask.sum()),
        "bbox": box(mask),
        **keypoints(view.places_px, view.flags),
    }


def board_category(number: int, target: Target) -> dict[str, Any]:
    """Give the category of a target: its points, neighbours joined along rows and columns."""
    lattice = [tuple(map(int, place)) for place in target.lattice]
    numbers = {place: k for k, place in enumerate(lattice, start=1)}
    steps = ((1, 0), (0, 1))
    joined = [
        [k, numbers[column + right, row + down]]
        for (column, row), k in numbers.items()
        for right, down in steps
        if (column + right, row + down) in numbers
    ]
    return {
        "id": number,
        "name": str(target),
        "supercategory": "calibration target",
        "keypoints": [f"point_{k}" for k in range(len(lattice))],
        "skeleton": joined,
    }


def board_annotations(pair: BoardPair, category: int) -> Iterator[dict[str, Any]]:
    """Give the annotations of a board in both images, without their ids; no segmentation."""
    for places, visible in zip(pair.points_px, pair.visible, strict=True):
        seen = places[visible]
        corner, size = np.zeros(2), np.zeros(2)
        if len(seen):  # as a box, which counts from the pixel's corner
            corner, size = seen.min(axis=0) + 0.5, np.ptp(seen, axis=0)
        yield {
            "category_id": category,
            "iscrowd": 0,
            "area": float(size.prod()),
            "bbox": [*corner.tolist(), *size.tolist()],
            **keypoints(places, tuple(SEEN if one else ABSENT for one in visible)),
        }


def keypoints(places_px: Array, flags: Sequence[int]) -> dict[str, Any]:
    """Give points (n, 2) as COCO lists them: x, y, flag; (0, 0) is the first pixel's centre."""
    listed: list[float] = []
    for (u, v), flag in zip(places_px.tolist(), flags, strict=True):
        listed += [u, v, flag] if flag else [0, 0, ABSENT]
    return {"keypoints": listed, "num_keypoints": sum(flag > 0 for flag in flags)}


def run_lengths(mask: Mask) -> dict[str, Any]:
    """Give COCO's uncompressed run lengths: down the columns, zeros first."""
    flat = np.concatenate([[False], mask.ravel(order="F")])
    turns = np.flatnonzero(flat[1:] != flat[:-1])
    counts = np.diff(np.concatenate([[0], turns, [mask.size]]))
    return {"size": list(mask.shape), "counts": counts.tolist()}


def box(mask: Mask) -> list[int]:
    """Give the box around a mask's pixels: x, y of their corner, width, height."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    x, y = int(columns[0]), int(rows[0])
    return [x, y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1]
