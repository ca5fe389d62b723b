"""What every format's numbers have to be to make a rig."""

from __future__ import annotations

import numpy as np

from simtip.camera import DISTORTION_LENGTHS
from simtip.geometry import Array, nearest_rotation
from simtip.rig_file.field import MAX_MAGNITUDE, Field

MIN_BASELINE_MM = 1.0
"""Below this the two cameras are one."""

MAX_BASELINE_M = 20.0
"""Above this a file that has to be in metres is taken to be in millimetres."""


def check_intrinsics(field: Field, K: Array) -> None:
    """Refuse what is no intrinsic matrix (3, 3) without skew, px.

    Raises
    ------
    InputError
        It is singular, skewed or of another form.
    """
    fx, skew, fy = K[0, 0], K[0, 1], K[1, 1]
    if fx <= 1 / MAX_MAGNITUDE or fy <= 1 / MAX_MAGNITUDE:
        raise field.error(
            f"is singular: the focal lengths are {fx:g} and {fy:g} px",
            remedy="give fx and fy above 0",
        )
    if skew != 0:
        raise field.error(
            f"has skew {skew:g}, which is not supported", remedy="calibrate without skew"
        )
    if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
        raise field.error("is not an intrinsic matrix", remedy="give [fx 0 cx; 0 fy cy; 0 0 1]")


def coefficients(
    field: Field, D: Array, lengths: tuple[int, ...] = DISTORTION_LENGTHS
) -> tuple[float, ...]:
    """Give the coefficients of distortion, in OpenCV's order.

    Raises
    ------
    InputError
        They are not as many as the model has.
    """
    # A column, a row or one dimension: anything else has its coefficients in an unknown order.
    if D.size not in lengths or D.size not in {0, max(D.shape)}:
        shape = " x ".join(map(str, D.shape))
        raise field.error(
            f"has {shape} coefficients", remedy=f"give one row of {', '.join(map(str, lengths))}"
        )
    return tuple(D.ravel().tolist())


def rotation(field: Field, R: Array, remedy: str) -> Array:
    """Give the rotation (3, 3) that a matrix is up to the rounding of its digits.

    Raises
    ------
    InputError
        It is none.
    """
    try:
        return nearest_rotation(R)
    except ValueError as error:
        raise field.error(f"is {error}", remedy=remedy) from error


def check_baseline(field: Field, t_mm: Array) -> None:
    """Refuse a translation (3,), mm, that is too short: it may be in metres.

    Raises
    ------
    InputError
        It is.
    """
    baseline = float(np.linalg.norm(t_mm))
    if not baseline >= MIN_BASELINE_MM:
        raise field.error(
            f"makes a baseline of {baseline:.3g} mm",
            remedy="give the T of cv2.stereoCalibrate in mm: multiply metres by 1000",
        )


def millimetres(field: Field, t_m: Array) -> Array:
    """Convert a translation (3,) from m to mm.

    Raises
    ------
    InputError
        It is too short, or so long that it seems to be in millimetres already.
    """
    baseline, least = float(np.linalg.norm(t_m)), MIN_BASELINE_MM / 1000
    if not least <= baseline <= MAX_BASELINE_M:
        raise field.error(
            f"makes a baseline of {baseline:.3g} m",
            remedy=f"this format is in metres: give {least:g} to {MAX_BASELINE_M:g}",
        )
    return 1000.0 * t_m
