"""One detector on single image files of any origin."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simtip.detect import ConfiguredDetector, TipObservation
from simtip.detect.region import Region, within
from simtip.errors import InputError
from simtip.image_file import Image, read_image


@dataclass(frozen=True, eq=False)
class Detection:
    """What a detector saw in one image file.

    Attributes
    ----------
    file
        As it was named.
    image
        (H, W) or (H, W, 3), as stored.
    observation
        In px of the whole image.
    time_s
        Wall time of the detector, s.
    """

    file: Path
    image: Image
    observation: TipObservation
    time_s: float

    def to_dict(self) -> dict[str, Any]:
        """Give plain lists and numbers: an item of ``detect --json``."""
        seen = self.observation
        arrays = {
            "tip_px": seen.tip_px,
            "axis": seen.axis_px,
            "covariance_px": seen.covariance_px,
        }
        return {
            "image": str(self.file),
            "status": str(seen.status),
            "reason": seen.reason,
            **{key: None if value is None else value.tolist() for key, value in arrays.items()},
            "confidence": seen.confidence,
            "time_s": self.time_s,
        }


def check_images(files: Sequence[Path]) -> list[tuple[int, ...]]:
    """Read every file once, so that a bad one is refused before work on others; give their shapes.

    Raises
    ------
    InputError
        A file is no image that can be read.
    """
    return [read_image(file).shape for file in files]


def detections(
    files: Sequence[Path],
    detector: ConfiguredDetector,
    *,
    region: Region | None = None,
    layers: bool = False,
    report: Callable[[float], None] | None = None,
) -> Iterator[Detection]:
    """Look for the needle tip in each file in turn; one image is in memory at a time.

    Parameters
    ----------
    files
        Images of any origin.
    detector
        See `simtip.detect.configure`.
    region
        Where to look; None is everywhere.
    layers
        Keep the detector's intermediate images.
    report
        Told the share that is done.

    Raises
    ------
    InputError
        A file cannot be read, or the region or a setting of the detector does not suit it.
    """
    look = within(detector, region)
    for done, file in enumerate(files, start=1):
        image = read_image(file)
        start = time.perf_counter()
        with _about(file):
            seen = look(image, layers=layers)
        time_s = time.perf_counter() - start
        if report is not None:
            report(done / len(files))
        yield Detection(file, image, seen, time_s)


@contextmanager
def _about(file: Path) -> Iterator[None]:
    """Give an error about an image the name of its file."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        raise InputError(
            error.problem, file=file, field=error.field, remedy=error.remedy
        ) from error
