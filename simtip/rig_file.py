"""Stereo rigs as OpenCV FileStorage YAML, as users of `cv2.stereoCalibrate` keep them.

OpenCV's pose is ``p_right = R p_left + T``; `StereoRig.T_lr` is its inverse (paper Eq. 19).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np

from simtip.camera import DISTORTION_LENGTHS, Camera, StereoRig
from simtip.geometry import Pose, nearest_rotation
from simtip.output_folder import write_atomically
from simtip.rig_nodes import MAX_MAGNITUDE, MAX_SIDE, load_nodes, read_matrix
from simtip.yaml_file import shown

if TYPE_CHECKING:
    from pathlib import Path

    from simtip.geometry import Array
    from simtip.yaml_file import Document, FieldPath, Yaml

Size: TypeAlias = tuple[int, int]

MIN_BASELINE_MM = 1.0
"""Below this the two cameras are one."""


def read_rig(
    path: str | Path, size: Size | None = None, right_size: Size | None = None
) -> StereoRig:
    """Read a stereo rig from an OpenCV FileStorage YAML file.

    Nodes (other names in brackets), each a matrix ``!!opencv-matrix``:

    - ``M1`` (``K1``, ``cameraMatrix1``), ``M2`` likewise: (3, 3) intrinsics, px, no skew.
    - ``D1`` (``distCoeffs1``), ``D2`` likewise: 0, 4, 5, 8, 12 or 14 coefficients of OpenCV's
      standard model; not those of ``cv2.fisheye``.
    - ``R``: (3, 3), or (3,) Rodrigues vector; ``T``: 3 values, mm (so the calibration board's
      squares were given in mm). OpenCV's convention, ``p_right = R p_left + T``.
    - Optional: ``image_width`` and ``image_height``, or ``image_size`` (``imageSize``)
      ``[width, height]`` for both cameras, or ``image_size1`` and ``image_size2``.

    Other nodes (``E``, ``F``, ``R1``, ``P1``, ``Q``, ...) are ignored.

    Parameters
    ----------
    path
        The file.
    size
        (width, height) of the left images, px, for a file that does not say.
    right_size
        The same of the right images; as the left by default.

    Returns
    -------
    StereoRig
        ``T_lr`` maps right-camera to left-camera coordinates, mm.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the node and the remedy.
    """
    document = load_nodes(path)
    left_size, right_size = _sizes(document, size, right_size or size)
    left = _camera(document, "M1", "D1", left_size)
    right = _camera(document, "M2", "D2", right_size)
    T_rl = Pose(_rotation(document), _translation(document))
    return StereoRig(left, right, T_rl.inverse())


def write_rig(path: str | Path, rig: StereoRig) -> None:
    """Write a rig as OpenCV FileStorage YAML, which OpenCV and `read_rig` read.

    Numbers are written so that they read back to the same floats. The file appears whole or not
    at all.

    Parameters
    ----------
    path
        The file; an existing one is replaced.
    rig
        What to write.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_atomically(path, rig_text(rig).encode())


def rig_text(rig: StereoRig) -> str:
    """Give the text that `write_rig` writes."""
    T_rl = rig.T_lr.inverse()
    # OpenCV 3 and 4 accept no other first line.
    lines = [
        "%YAML:1.0",
        "---",
        "# Stereo rig. Lengths in mm; pixel (0, 0) is the centre of the top-left pixel.",
        "# OpenCV's convention: p_right = R p_left + T, from left to right camera coordinates.",
        "# Camera coordinates: x right, y down, z forward. 1 is the left camera, 2 the right.",
        *_size_lines(rig),
    ]
    for name, camera in (("1", rig.left), ("2", rig.right)):
        lines += _matrix_lines(f"M{name}", camera.K)
        lines += _matrix_lines(f"D{name}", np.array([camera.distortion or (0.0,) * 5]))
    lines += _matrix_lines("R", T_rl.R)
    lines += _matrix_lines("T", T_rl.t.reshape(3, 1))
    return "\n".join(lines) + "\n"


def _size_lines(rig: StereoRig) -> list[str]:
    if rig.left.size == rig.right.size:
        return [f"image_width: {rig.left.width}", f"image_height: {rig.left.height}"]
    return [
        f"image_size{name}: [ {camera.width}, {camera.height} ]"
        for name, camera in (("1", rig.left), ("2", rig.right))
    ]


def _matrix_lines(name: str, matrix: Array) -> list[str]:
    rows = [", ".join(repr(float(x)) for x in row) for row in matrix]
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {matrix.shape[0]}",
        f"   cols: {matrix.shape[1]}",
        "   dt: d",
        "   data: [ " + ",\n       ".join(rows) + " ]",
    ]


def _camera(document: Document, matrix: str, distortion: str, size: Size) -> Camera:
    path, K = read_matrix(document, matrix, (3, 3))
    fx, skew, fy = K[0, 0], K[0, 1], K[1, 1]
    if fx <= 1 / MAX_MAGNITUDE or fy <= 1 / MAX_MAGNITUDE:
        raise document.error(
            f"is singular: the focal lengths are {fx:g} and {fy:g} px",
            path,
            remedy="give fx and fy above 0",
        )
    if skew != 0:
        raise document.error(
            f"has skew {skew:g}, which is not supported", path, remedy="calibrate without skew"
        )
    if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
        raise document.error(
            "is not an intrinsic matrix", path, remedy="give [fx 0 cx; 0 fy cy; 0 0 1]"
        )
    return Camera(K, *size, distortion=_distortion(document, distortion))


def _distortion(document: Document, name: str) -> tuple[float, ...]:
    path, D = read_matrix(document, name)
    # A column, a row or one dimension: anything else has its coefficients in an unknown order.
    if D.size not in DISTORTION_LENGTHS or D.size not in {0, max(D.shape)}:
        shape = " x ".join(map(str, D.shape))
        raise document.error(
            f"has {shape} coefficients",
            path,
            remedy=f"give one row of {', '.join(map(str, DISTORTION_LENGTHS))}",
        )
    return tuple(D.ravel().tolist())


def _rotation(document: Document) -> Array:
    path, R = read_matrix(document, "R", (3, 3), (3, 1), (1, 3), (3,))
    if R.size == 3:
        R = np.asarray(cv2.Rodrigues(R.reshape(3, 1))[0], dtype=np.float64)
    try:
        return nearest_rotation(R)
    except ValueError as error:
        raise document.error(
            f"is {error}", path, remedy="give the R of cv2.stereoCalibrate"
        ) from error


def _translation(document: Document) -> Array:
    path, T = read_matrix(document, "T", (3, 1), (1, 3), (3,))
    baseline = float(np.linalg.norm(T))
    if baseline < MIN_BASELINE_MM:
        raise document.error(
            f"makes a baseline of {baseline:.3g} mm",
            path,
            remedy="give the T of cv2.stereoCalibrate in mm: multiply metres by 1000",
        )
    return T.ravel()


def _sizes(document: Document, left: Size | None, right: Size | None) -> tuple[Size, Size]:
    """Give the sizes that the file states, else those of the images."""
    nodes = document.value if isinstance(document.value, dict) else {}
    if "image_width" in nodes or "image_height" in nodes:
        both = (
            _side(document, ("image_width",), nodes.get("image_width")),
            _side(document, ("image_height",), nodes.get("image_height")),
        )
        return both, both
    left = _listed(document, nodes, ("image_size1", "image_size", "imageSize")) or left
    right = _listed(document, nodes, ("image_size2", "image_size", "imageSize")) or right
    if left is None or right is None:
        raise document.error(
            "the image size is missing",
            ("image_width",),
            remedy="add image_width and image_height, px",
        )
    return left, right


def _listed(document: Document, nodes: dict[str, Yaml], names: tuple[str, ...]) -> Size | None:
    name = next((n for n in names if n in nodes), None)
    if name is None:
        return None
    sides = nodes[name]
    if not isinstance(sides, list) or len(sides) != 2:
        raise document.error(f"is {shown(sides)}", (name,), remedy="give [width, height], px")
    return _side(document, (name, 0), sides[0]), _side(document, (name, 1), sides[1])


def _side(document: Document, path: FieldPath, side: Yaml) -> int:
    # Written from a C++ double, a size reads "2048.".
    number = -1 if isinstance(side, bool) or not isinstance(side, int | float) else side
    if 1 <= number <= MAX_SIDE and number == int(number):
        return int(number)
    raise document.error(
        f"is {shown(side)}", path, remedy=f"give a whole number of px from 1 to {MAX_SIDE}"
    )
