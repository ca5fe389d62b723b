"""What a format with fewer coefficients, or a narrower range, can carry of a rig."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Array
from simtip.rig_file.checks import MAX_BASELINE_M, MIN_BASELINE_MM

INSTEAD = "write it as opencv, opencv-xml or json, which hold everything"


def needed_coefficients(camera: Camera) -> tuple[float, ...]:
    """Give the coefficients up to the last that is not 0: more zeros change nothing."""
    last = max((i for i, c in enumerate(camera.distortion, 1) if c), default=0)
    return camera.distortion[:last]


def padded(coefficients: tuple[float, ...], length: int) -> list[float]:
    """Fill up with zeros."""
    return [*coefficients, *[0.0] * (length - len(coefficients))]


def metres(path: str | Path | None, rig: StereoRig, t_mm: Array) -> Array:
    """Convert a translation (3,) to m, refusing what would be refused on reading.

    Raises
    ------
    InputError
        The rig's baseline is out of range.
    """
    baseline = float(np.linalg.norm(rig.T_lr.t))
    if not MIN_BASELINE_MM / 1000 <= baseline / 1000 <= MAX_BASELINE_M:
        raise InputError(
            f"the baseline is {baseline:.3g} mm, and this format takes {MIN_BASELINE_MM:g} mm to "
            f"{MAX_BASELINE_M:g} m",
            file=path,
            field="rig",
            remedy=INSTEAD,
        )
    return t_mm / 1000.0
