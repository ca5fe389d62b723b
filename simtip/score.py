"""A measured tip against the true one: signed errors, measured - true.

Millimetres are those of the rig frame (x right, y down, z forward, left camera). Pixels are those
of the images as they are. Plain arrays in, so that any source of truth will do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array

MaybeArray: TypeAlias = ArrayLike | None

UNIT_TOLERANCE = 1e-6
"""How far from 1 the length of an axis may be."""


@dataclass(frozen=True)
class PointError:
    """Error of a 3-D point, measured - true, mm, in the rig frame."""

    x_mm: float
    y_mm: float
    z_mm: float

    @property
    def norm_mm(self) -> float:
        """Length of the error, mm, never negative."""
        return float(np.linalg.norm([self.x_mm, self.y_mm, self.z_mm]))


@dataclass(frozen=True)
class PixelError:
    """Error of an image point, measured - true, px.

    Attributes
    ----------
    u_px, v_px
        To the right and down.
    along_px
        Along the needle's true axis, which points from the tip to the hub. Above 0 the measured
        tip is too near the hub: it recedes. None if the axis is unknown.
    across_px
        Along the axis turned by 90 degrees clockwise as one sees the picture, which takes
        (a_u, a_v) to (-a_v, a_u). For a needle hanging tip down, with the axis up in the picture,
        above 0 is to the right. None if the axis is unknown.
    """

    u_px: float
    v_px: float
    along_px: float | None
    across_px: float | None

    @property
    def norm_px(self) -> float:
        """Length of the error, px, never negative."""
        return float(np.hypot(self.u_px, self.v_px))


@dataclass(frozen=True)
class TipError:
    """Errors of one stereo measurement; None for what was not measured or has no truth."""

    point: PointError | None
    left: PixelError | None
    right: PixelError | None


def score_tip(
    *,
    point_measured_mm: MaybeArray = None,
    point_true_mm: MaybeArray = None,
    tips_measured_px: tuple[MaybeArray, MaybeArray] = (None, None),
    tips_true_px: tuple[MaybeArray, MaybeArray] = (None, None),
    axes_true_px: tuple[MaybeArray, MaybeArray] = (None, None),
) -> TipError:
    """Compare a measurement with the truth, in space and in both views.

    Parameters
    ----------
    point_measured_mm, point_true_mm
        (3,) in the rig frame, or None.
    tips_measured_px, tips_true_px
        Left and right (2,) u, v, each or None.
    axes_true_px
        Left and right (2,) unit direction in the image, at the tip, from tip to hub, or None.

    Raises
    ------
    ValueError
        A shape is wrong, a number is not finite, or an axis is not of length 1.
    """
    left, right = (
        pixel_error(measured, true, axis)
        for measured, true, axis in zip(tips_measured_px, tips_true_px, axes_true_px, strict=True)
    )
    return TipError(point_error(point_measured_mm, point_true_mm), left, right)


def point_error(measured_mm: MaybeArray, true_mm: MaybeArray) -> PointError | None:
    """Give the error of a point (3,), mm; None if either is missing."""
    if measured_mm is None or true_mm is None:
        return None
    error = _numbers(measured_mm, 3) - _numbers(true_mm, 3)
    return PointError(*map(float, error))


def pixel_error(
    measured_px: MaybeArray, true_px: MaybeArray, axis_px: MaybeArray = None
) -> PixelError | None:
    """Give the error of an image point (2,), px, along and across the axis; None if missing.

    Raises
    ------
    ValueError
        A shape is wrong, a number is not finite, or the axis is not of length 1.
    """
    if measured_px is None or true_px is None:
        return None
    error = _numbers(measured_px, 2) - _numbers(true_px, 2)
    along = across = None
    if axis_px is not None:
        axis = _numbers(axis_px, 2)
        if abs(np.linalg.norm(axis) - 1) > UNIT_TOLERANCE:
            raise ValueError(f"an axis has the length 1, not {np.linalg.norm(axis):g}")
        along = float(error @ axis)
        across = float(error @ np.array([-axis[1], axis[0]]))
    return PixelError(float(error[0]), float(error[1]), along, across)


def _numbers(values: ArrayLike, count: int) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"expected {count} finite numbers, not {values!r}")
    return array
