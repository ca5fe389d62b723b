"""ROS camera_info YAML: two files, left and right, as camera_calibration writes them, in metres.

There is no R and T in them. Each camera has a rotation R_i into rectified axes, which the two share
(``rectification_matrix``), and P_i projects points in the left one's rectified frame into its
rectified image (``projection_matrix``, by sensor_msgs/CameraInfo)::

    P_left = [K' | 0],  P_right = [K' | K' t],  K' t = (-fx' B, 0, 0) for cameras side by side

with t from left to right rectified coordinates, so that OpenCV's pose is
``R = R_right^T R_left`` and ``T = R_right^T t``. Lengths are metres (REP 103).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Array, Pose
from simtip.rig_file.carried import INSTEAD, metres, needed_coefficients, padded
from simtip.rig_file.checks import check_intrinsics, coefficients, millimetres, rotation
from simtip.rig_file.exact import listed
from simtip.rig_file.field import MAX_MAGNITUDE, Field
from simtip.rig_file.matrix import read_matrix
from simtip.rig_file.rectification import rectify
from simtip.yaml_file import Document, shown

REMEDY = "compare it with the left.yaml and right.yaml of ROS's camera_calibration"
PLUMB_BOB, RATIONAL = 5, 8
"""How many coefficients ROS's two models have that OpenCV's standard model holds."""
MODELS = {"plumb_bob": (0, 4, PLUMB_BOB), "rational_polynomial": (RATIONAL,)}
ALONE_M = 1e-6
"""Below this a camera's rectified frame is its own."""


@dataclass(frozen=True, eq=False)
class _Half:
    """One file: a camera, its rotation (3, 3) into the rectified frame, and t (3,), m, there."""

    camera: Camera
    R: Array
    t_m: Array
    P: Field


def is_ros(document: Document) -> bool:
    """Say whether a YAML document is one camera's camera_info."""
    rectified = {"rectification_matrix", "projection_matrix"}
    return isinstance(document.value, dict) and bool(rectified & set(document.value))


def rig_from_ros(left: Document, right: Document) -> StereoRig:
    """Make the rig of a pair of camera_info documents.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the field and the remedy.
    """
    halves = _half(left), _half(right)
    alone = [float(np.linalg.norm(half.t_m)) <= ALONE_M for half in halves]
    if alone == [True, True]:
        raise halves[1].P.error(
            "has no baseline: its fourth column is 0",
            remedy="calibrate the two cameras together, as a stereo pair",
        )
    if not alone[0]:
        swapped = "; the two files are swapped" if alone[1] else ""
        raise halves[0].P.error(
            f"is not a left camera's: its fourth column is not 0{swapped}",
            remedy="name the files by the sides of the cameras",
        )
    t_mm = millimetres(halves[1].P, halves[1].t_m)
    T_rl = Pose(halves[1].R.T @ halves[0].R, halves[1].R.T @ t_mm)
    return StereoRig(halves[0].camera, halves[1].camera, T_rl.inverse())


def _half(document: Document) -> _Half:
    root = Field.root(document, REMEDY)
    size = root.child("image_width").side(), root.child("image_height").side()
    matrix, turned = root.child("camera_matrix"), root.child("rectification_matrix")
    K = read_matrix(matrix, (3, 3), typed=False)
    check_intrinsics(matrix, K)
    R = rotation(turned, read_matrix(turned, (3, 3), typed=False), REMEDY)
    P = root.child("projection_matrix")
    return _Half(Camera(K, *size, distortion=_distortion(root)), R, _offset(P), P)


def _offset(field: Field) -> Array:
    """Give t (3,), m, of P = K' [I | t]."""
    P = read_matrix(field, (3, 4), typed=False, limit=MAX_MAGNITUDE**2)
    check_intrinsics(field, P[:, :3])
    if P[2, 3] != 0:
        raise field.error("is of cameras not side by side: its last entry is not 0")
    return np.array([P[0, 3] / P[0, 0], P[1, 3] / P[1, 1], 0.0])


def _distortion(root: Field) -> tuple[float, ...]:
    model = "plumb_bob"  # what ROS assumes where none is named
    if "distortion_model" in root.names():
        field = root.child("distortion_model")
        model = field.text()
        if model not in MODELS:
            raise field.error(
                f"is {shown(model)}, which OpenCV's standard model cannot hold",
                remedy=f"calibrate with {' or '.join(MODELS)}",
            )
    values = root.child("distortion_coefficients")
    return coefficients(values, read_matrix(values, typed=False), MODELS[model])


def ros_texts(rig: StereoRig, path: str | Path | None = None) -> tuple[str, str]:
    """Write a rig as a pair of camera_info files, left and right.

    Parameters
    ----------
    rig
        What to write.
    path
        The file or folder, for messages.

    Raises
    ------
    InputError
        The format cannot hold the rig.
    """
    views = rectify(rig)
    t_m = metres(path, rig, views.t_mm)
    P_left = np.column_stack([views.K, np.zeros(3)])
    P_right = np.column_stack([views.K, views.K[0, 0] * t_m])
    return (
        _text(rig.left, "left", views.R_left, P_left, path),
        _text(rig.right, "right", views.R_right, P_right, path),
    )


def _text(camera: Camera, side: str, R: Array, P: Array, path: str | Path | None) -> str:
    model, distortion = _model(camera, side, path)
    lines = [
        f"# The {side} camera of a stereo pair as ROS camera_info; the other's file goes with it.",
        "# Lengths in METRES. p_rectified = rectification_matrix p_camera. projection_matrix is",
        "# [K' | K' t], t from left to right rectified coordinates, 0 for the left camera.",
        "# Hence p_right = R p_left + T with R = R_right^T R_left and T = R_right^T t.",
        "# Camera coordinates: x right, y down, z forward; pixel (0, 0) is the centre of the",
        "# top-left pixel. Coefficients in OpenCV's order.",
        f"image_width: {camera.width}",
        f"image_height: {camera.height}",
        f"camera_name: {side}",
        *_matrix_lines("camera_matrix", camera.K),
        f"distortion_model: {model}",
        *_matrix_lines("distortion_coefficients", np.array([distortion])),
        *_matrix_lines("rectification_matrix", R),
        *_matrix_lines("projection_matrix", P),
    ]
    return "\n".join(lines) + "\n"


def _model(camera: Camera, side: str, path: str | Path | None) -> tuple[str, list[float]]:
    distortion = needed_coefficients(camera)
    if len(distortion) <= PLUMB_BOB:
        return "plumb_bob", padded(distortion, PLUMB_BOB)
    if len(distortion) <= RATIONAL:
        return "rational_polynomial", padded(distortion, RATIONAL)
    raise InputError(
        f"has {len(distortion)} coefficients, and ROS holds {PLUMB_BOB} (plumb_bob) or {RATIONAL} "
        "(rational_polynomial)",
        file=path,
        field=f"{side}.distortion",
        remedy=f"{INSTEAD}, or calibrate without thin prism and tilt",
    )


def _matrix_lines(name: str, matrix: Array) -> list[str]:
    return [
        f"{name}:",
        f"  rows: {matrix.shape[0]}",
        f"  cols: {matrix.shape[1]}",
        "  data: [" + ",\n         ".join(listed(row) for row in matrix) + "]",
    ]
