"""The points of a target seen in one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.geometry import Array


@dataclass(frozen=True, eq=False)
class Sighting:
    """Points of a target with their places in one image.

    Attributes
    ----------
    ids
        (n,) which of the target's points, strictly ascending.
    pixels
        (n, 2) u, v in px of the image as given: not undistorted.
    """

    ids: NDArray[np.intp]
    pixels: Array

    def __post_init__(self) -> None:
        ids = np.array(self.ids, dtype=np.intp).reshape(-1)
        pixels = np.array(self.pixels, dtype=np.float64)
        if pixels.shape != (len(ids), 2) or not np.isfinite(pixels).all():
            raise ValueError("each id needs one finite pixel (u, v)")
        if (ids < 0).any() or (np.diff(ids) <= 0).any():
            raise ValueError("ids have to be ascending, from 0, each once")
        ids.setflags(write=False)
        pixels.setflags(write=False)
        object.__setattr__(self, "ids", ids)
        object.__setattr__(self, "pixels", pixels)

    def __len__(self) -> int:
        return len(self.ids)
