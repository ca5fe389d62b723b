"""Pairs of images as trials share them, and as the cache keeps them."""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from simtip.sensor import Image

SIDES = ("left", "right")


@dataclass(frozen=True, eq=False)
class Shot:
    """A pair of images and what a table says of how they came about."""

    images: tuple[Image, Image]
    exposure_s: float


def unchangeable(shot: Shot) -> Shot:
    """Give a shot whose images no detector can change for those after it, whatever it tries."""
    left, right = map(_immutable, shot.images)
    return Shot((left, right), shot.exposure_s)


def _immutable(image: Image) -> Image:
    return cast("Image", np.frombuffer(image.tobytes(), image.dtype).reshape(image.shape))


def write_shot(folder: Path, shot: Shot) -> None:
    """Write a pair of images into a folder.

    Raises
    ------
    OSError
        The disk is full, for example.
    """
    about: dict[str, Any] = {"exposure_s": shot.exposure_s}
    for side, image in zip(SIDES, shot.images, strict=True):
        np.save(folder / f"{side}.npy", image, allow_pickle=False)
        about[side] = zlib.crc32(np.ascontiguousarray(image).data)
    (folder / "about.json").write_text(json.dumps(about), encoding="utf-8")


def read_shot(folder: Path) -> Shot | None:
    """Read a pair of images; None if they are not as they were written."""
    try:
        about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
        images = [np.load(folder / f"{side}.npy", allow_pickle=False) for side in SIDES]
        whole = all(
            zlib.crc32(np.ascontiguousarray(image).data) == about[side]
            for side, image in zip(SIDES, images, strict=True)
        )
        exposure_s = float(about["exposure_s"])
    except (OSError, ValueError, KeyError, TypeError, EOFError):
        return None
    return Shot((images[0], images[1]), exposure_s) if whole else None
