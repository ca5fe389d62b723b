"""simtip's own JSON: plain keys, units in their names, conventions stated, a version."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose
from simtip.rig_file.checks import check_baseline, check_intrinsics, coefficients, rotation
from simtip.rig_file.field import Field
from simtip.rig_file.opencv import Size
from simtip.yaml_file import Document, shown

FORMAT = "simtip-rig"
VERSION = 1

CONVENTIONS = {
    "pose": "p_left = R p_right + T_mm, from right to left: the inverse of OpenCV's",
    "camera": "x right, y down, z forward; lengths in mm",
    "pixel": "(0, 0) is the centre of the top-left pixel",
    "K": "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], px",
    "D": "OpenCV's order: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]; [] is none",
    "size": "[width, height], px",
}


def is_own(document: Document) -> bool:
    """Say whether a JSON document is meant as simtip's own, rather than as OpenCV's nodes."""
    return isinstance(document.value, dict) and bool({"format", "K_left"} & set(document.value))


def rig_from_json(document: Document) -> StereoRig:
    """Make the rig of simtip's own JSON; keys that it does not define are ignored.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the key and the remedy.
    """
    root = Field.root(document, "compare it with what `simtip rig --format json` writes")
    kind, version = root.child("format"), root.child("version")
    if kind.value != FORMAT:
        raise kind.error(f"is {shown(kind.value)}", remedy=f'a rig has "{FORMAT}"')
    if type(version.value) is not int or version.value != VERSION:
        raise version.error(
            f"is {shown(version.value)}; this simtip reads version {VERSION}",
            remedy="update simtip, or write the rig again",
        )
    left, right = (_camera(root, side) for side in ("left", "right"))
    R = rotation(
        root.child("R"), root.child("R").rows((3, 3)), "give R^T of cv2.stereoCalibrate's R"
    )
    T = root.child("T_mm")
    t = T.numbers()
    if t.shape != (3,):
        raise T.error(f"has {t.size} numbers", remedy="give 3, mm")
    check_baseline(T, t)
    return StereoRig(left, right, Pose(R, t))


def _camera(root: Field, side: str) -> Camera:
    matrix, distortion = root.child(f"K_{side}"), root.child(f"D_{side}")
    K = matrix.rows((3, 3))
    check_intrinsics(matrix, K)
    size: Size = root.child(f"size_{side}").sides()
    return Camera(K, *size, distortion=coefficients(distortion, distortion.numbers()))


def json_text(rig: StereoRig) -> str:
    """Write a rig as simtip's own JSON."""
    contents: dict[str, Any] = {"format": FORMAT, "version": VERSION, "conventions": CONVENTIONS}
    for side, camera in (("left", rig.left), ("right", rig.right)):
        contents |= {
            f"size_{side}": list(camera.size),
            f"K_{side}": camera.K.tolist(),
            f"D_{side}": list(camera.distortion),
        }
    contents |= {"R": rig.T_lr.R.tolist(), "T_mm": np.asarray(rig.T_lr.t).tolist()}
    # One line for each key: neither one long line nor one line for each number.
    lines = (f"  {json.dumps(key)}: {_value_text(value)}" for key, value in contents.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _value_text(value: Any) -> str:
    if isinstance(value, dict):
        inner = (f"    {json.dumps(key)}: {json.dumps(text)}" for key, text in value.items())
        return "{\n" + ",\n".join(inner) + "\n  }"
    return json.dumps(value, allow_nan=False)
