"""Kalibr's camchain YAML: two pinhole cameras with radial-tangential distortion, metres.

``T_cn_cnm1`` of a camera maps the coordinates of the one before it to its own (Kalibr's wiki, "Yaml
formats"): cam1's is OpenCV's R and T from cam0, the left camera, to cam1, the right one. Its
``radtan`` coefficients k1 k2 r1 r2 are OpenCV's k1 k2 p1 p2.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Pose
from simtip.rig_file.carried import INSTEAD, metres, needed_coefficients, padded
from simtip.rig_file.checks import check_intrinsics, coefficients, millimetres, rotation
from simtip.rig_file.exact import listed
from simtip.rig_file.field import Field
from simtip.yaml_file import Document, shown

POSE = "T_cn_cnm1"
REMEDY = "compare it with a camchain.yaml of kalibr_calibrate_cameras"
RADTAN = 4
"""How many coefficients radtan has."""

_CAMERA = re.compile(r"cam[0-9]+\Z")


def is_kalibr(document: Document) -> bool:
    """Say whether a YAML document is a chain of cameras."""
    return isinstance(document.value, dict) and any(map(_CAMERA.match, document.value))


def rig_from_kalibr(document: Document) -> StereoRig:
    """Make the rig of a chain of two cameras; IMU, topics and overlaps are ignored.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the field and the remedy.
    """
    root = Field.root(document, REMEDY)
    cameras = sorted(filter(_CAMERA.match, root.names()))
    if cameras != ["cam0", "cam1"]:
        raise root.error(
            f"has the cameras {', '.join(cameras)}", remedy="a rig has cam0, left, and cam1, right"
        )
    pose = root.child("cam1").child(POSE)
    T = pose.rows((4, 4))
    if T[3].tolist() != [0, 0, 0, 1]:
        raise pose.error("is no rigid transform", remedy="its last row has to be [0, 0, 0, 1]")
    R = rotation(pose, T[:3, :3], REMEDY)
    T_rl = Pose(R, millimetres(pose, T[:3, 3]))
    left, right = (_camera(root.child(name)) for name in cameras)
    return StereoRig(left, right, T_rl.inverse())


def _camera(camera: Field) -> Camera:
    model = camera.child("camera_model")
    if model.text() != "pinhole":
        raise model.error(
            f"is {shown(model.value)}, which OpenCV's standard model cannot hold",
            remedy="calibrate with pinhole-radtan",
        )
    intrinsics = camera.child("intrinsics")
    values = intrinsics.numbers()
    if values.shape != (4,):
        raise intrinsics.error(f"has {values.size} numbers", remedy="give [fu, fv, pu, pv], px")
    fx, fy, cx, cy = values
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    check_intrinsics(intrinsics, K)
    return Camera(K, *camera.child("resolution").sides(), distortion=_distortion(camera))


def _distortion(camera: Field) -> tuple[float, ...]:
    model, values = camera.child("distortion_model"), camera.child("distortion_coeffs")
    lengths = {"radtan": RADTAN, "none": 0}
    if model.text() not in lengths:
        raise model.error(
            f"is {shown(model.value)}, which OpenCV's standard model cannot hold",
            remedy="calibrate with pinhole-radtan",
        )
    return coefficients(values, values.numbers(), (lengths[model.text()],))


def kalibr_text(rig: StereoRig, path: str | Path | None = None) -> str:
    """Write a rig as a Kalibr camchain.

    Parameters
    ----------
    rig
        What to write.
    path
        The file, for messages.

    Raises
    ------
    InputError
        The format cannot hold the rig.
    """
    T_rl = rig.T_lr.inverse()
    t_m = metres(path, rig, T_rl.t)
    rows = [*(f"  - [{listed([*R, t])}]" for R, t in zip(T_rl.R, t_m, strict=True))]
    lines = [
        "# Stereo rig in Kalibr's camchain format: cam0 is the left camera, cam1 the right one.",
        f"# {POSE} maps cam0's coordinates to cam1's: p_right = R p_left + T, T in METRES.",
        "# Camera coordinates: x right, y down, z forward; pixel (0, 0) is the centre of the",
        "# top-left pixel. intrinsics: fx fy cx cy, px; radtan: k1 k2 p1 p2, as in OpenCV.",
        "cam0:",
        *_camera_lines(rig.left, "left", 0, path),
        "cam1:",
        f"  {POSE}:",
        *rows,
        "  - [0.0, 0.0, 0.0, 1.0]",
        *_camera_lines(rig.right, "right", 1, path),
    ]
    return "\n".join(lines) + "\n"


def _camera_lines(camera: Camera, side: str, number: int, path: str | Path | None) -> list[str]:
    distortion = needed_coefficients(camera)
    if len(distortion) > RADTAN:
        raise InputError(
            f"has {len(distortion)} coefficients, and Kalibr's radtan holds {RADTAN}",
            file=path,
            field=f"{side}.distortion",
            remedy=f"{INSTEAD}, or calibrate with --model radtan",
        )
    fx, fy, cx, cy = camera.K[0, 0], camera.K[1, 1], camera.K[0, 2], camera.K[1, 2]
    if min(cx, cy) < 0:
        raise InputError(
            f"has the principal point ({cx:g}, {cy:g}) px, and Kalibr takes none below 0",
            file=path,
            field=f"{side}.K",
            remedy=INSTEAD,
        )
    return [
        f"  cam_overlaps: [{1 - number}]",
        "  camera_model: pinhole",
        f"  distortion_coeffs: [{listed(padded(distortion, RADTAN))}]",
        "  distortion_model: radtan",
        f"  intrinsics: [{listed([fx, fy, cx, cy])}]",
        f"  resolution: [{camera.width}, {camera.height}]",
        f"  rostopic: /cam{number}/image_raw",
    ]
