"""Reading pairs of images and finding the target in them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from simtip.calibrate import Rejected, View
from simtip.calibration_images.pairs import Pair
from simtip.errors import InputError
from simtip.find_target import NotFound, find
from simtip.image_file import Image, read_image
from simtip.target import Sighting, Target

Size: TypeAlias = tuple[int, int]
Report: TypeAlias = Callable[[float], None]

CLIPPED_SHARE = 0.1
"""An image is overexposed if more of its target is at the end of the scale."""

MIN_VIEWS = 3
"""Zhang's method takes three positions of the board."""


@dataclass(frozen=True, eq=False)
class Looked:
    """What was seen.

    Attributes
    ----------
    views
        Those in which both cameras saw the target.
    pairs
        The files of these views.
    skipped
        The others, with reasons.
    sizes
        (width, height) of the left and of the right images, px.
    overexposed
        Images in which the target's bright parts are at the end of the scale.
    """

    views: tuple[View, ...]
    pairs: tuple[Pair, ...]
    skipped: tuple[Rejected, ...]
    sizes: tuple[Size, Size]
    overexposed: tuple[Path, ...]


def look_at(pairs: Sequence[Pair], target: Target, report: Report | None = None) -> Looked:
    """Read all images and find the target in them, on all cores.

    Every image is decoded before the search begins, so that a bad file is named at once.

    Parameters
    ----------
    pairs
        The files.
    target
        What they show.
    report
        Called with the fraction done.

    Raises
    ------
    InputError
        A file cannot be read, the images of a camera differ in size, or fewer than three views
        show the target to both cameras.
    """
    told = report or (lambda _: None)
    files = [file for pair in pairs for file in (pair.left, pair.right)]
    with _workers() as pool:
        sizes = list(pool.map(_size_of, files))
        left, right = (
            _one_size("left", files[::2], sizes[::2]),
            _one_size("right", files[1::2], sizes[1::2]),
        )
        seen: list[Sighting | NotFound] = []
        clipped: list[Path] = []
        for found, full in pool.map(lambda file: _look(target, file), files):
            if full:
                clipped.append(files[len(seen)])
            seen.append(found)
            told(len(seen) / len(files))
    views, kept, skipped = [], [], []
    for i, pair in enumerate(pairs):
        sightings = seen[2 * i], seen[2 * i + 1]
        faults = [
            f"{file.name}: {found.reason}"
            for file, found in zip((pair.left, pair.right), sightings, strict=True)
            if isinstance(found, NotFound)
        ]
        if faults:
            skipped.append(Rejected(pair.name, "; ".join(faults)))
            continue
        kept.append(pair)
        views.append(View(pair.name, *(s for s in sightings if isinstance(s, Sighting))))
    _require_views(target, len(views), seen)
    return Looked(tuple(views), tuple(kept), tuple(skipped), (left, right), tuple(clipped))


@contextmanager
def _workers() -> Iterator[ThreadPoolExecutor]:
    """Give a thread for each core: OpenCV lets others run. What waits is dropped at an error."""
    pool = ThreadPoolExecutor(max_workers=os.cpu_count() or 1)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _look(target: Target, file: Path) -> tuple[Sighting | NotFound, bool]:
    image = read_image(file)
    found = find(target, image)
    return found, isinstance(found, Sighting) and _clipped(image, found) > CLIPPED_SHARE


def _clipped(image: Image, sighting: Sighting) -> float:
    """Give the share of the pixels around the points that are at the end of the scale."""
    low = np.floor(sighting.pixels.min(axis=0)).astype(int).clip(0)
    high = np.ceil(sighting.pixels.max(axis=0)).astype(int) + 1
    part = image[low[1] : high[1], low[0] : high[0]]
    return float((part == np.iinfo(image.dtype).max).mean())


def _size_of(file: Path) -> Size:
    height, width = read_image(file).shape[:2]
    return width, height


def _one_size(camera: str, files: list[Path], sizes: list[Size]) -> Size:
    usual, count = Counter(sizes).most_common(1)[0]
    for file, size in zip(files, sizes, strict=True):
        if size != usual:
            raise InputError(
                f"is {size[0]} x {size[1]} px, {count} of the {len(files)} {camera} images are "
                f"{usual[0]} x {usual[1]} px",
                file=file,
                remedy="give images of one size: a calibration holds for one",
            )
    return usual


def _require_views(target: Target, count: int, seen: Sequence[Sighting | NotFound]) -> None:
    if count >= MIN_VIEWS:
        return
    reasons = Counter(found.reason for found in seen if isinstance(found, NotFound))
    why = f", mostly: {reasons.most_common(1)[0][0]}" if reasons else ""
    raise InputError(
        f"{target} was found by both cameras in {count} of {len(seen) // 2} views, {MIN_VIEWS} are "
        f"needed{why}",
        field="--target",
        remedy=(
            "say what was photographed (of a chessboard inner corners, along the row first), or "
            "take more views"
        ),
    )
