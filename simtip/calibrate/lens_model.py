"""Which of OpenCV's distortion coefficients a calibration estimates."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.errors import InputError
from simtip.geometry import Array

AUTO = "auto"
"""Stands for the model with the least Bayesian information criterion; see `choose_model`."""

LENGTH = 12
"""Numbers of a camera: fx, fy, cx, cy, px, then k1 k2 p1 p2 k3 k4 k5 k6."""


class LensModel(StrEnum):
    """A distortion model by name; the coefficients it leaves out are zero."""

    NONE = "none"
    """No distortion."""
    RADIAL2 = "radial2"
    """k1, k2."""
    RADTAN = "radtan"
    """k1, k2, p1, p2: Kalibr's radtan."""
    OPENCV5 = "opencv5"
    """k1, k2, p1, p2, k3: OpenCV's default."""
    RATIONAL = "rational"
    """k1, k2, p1, p2, k3 and, in the denominator, k4, k5, k6."""

    @property
    def coefficients(self) -> int:
        """How many coefficients a file gets: 0, or 5, or 8."""
        lengths = {"none": 0, "radial2": 5, "radtan": 5, "opencv5": 5, "rational": 8}
        return lengths[self.value]

    @property
    def free(self) -> NDArray[np.intp]:
        """Which of a camera's `LENGTH` numbers are estimated."""
        distortion = {
            "none": [],
            "radial2": [4, 5],
            "radtan": [4, 5, 6, 7],
            "opencv5": [4, 5, 6, 7, 8],
            "rational": [4, 5, 6, 7, 8, 9, 10, 11],
        }[self.value]
        return np.array([0, 1, 2, 3, *distortion], dtype=np.intp)


def lens_model(name: str) -> LensModel | None:
    """Look a model up by name; None for ``auto``.

    Raises
    ------
    InputError
        There is no such model.
    """
    if name == AUTO:
        return None
    try:
        return LensModel(name)
    except ValueError:
        known = ", ".join([*LensModel, AUTO])
        raise InputError(
            f"there is no distortion model {name!r}", field="model", remedy=f"give one of {known}"
        ) from None


def camera_of(numbers: Array, model: LensModel, size: tuple[int, int]) -> Camera:
    """Make the camera of `LENGTH` numbers; size is (width, height), px."""
    fx, fy, cx, cy = numbers[:4]
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return Camera(K, *size, distortion=tuple(numbers[4 : 4 + model.coefficients]))
