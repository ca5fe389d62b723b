"""Rigs as the nodes that users of `cv2.stereoCalibrate` keep, whatever text holds them.

OpenCV's pose is ``p_right = R p_left + T``; `StereoRig.T_lr` is its inverse (paper Eq. 19).
"""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.errors import InputError
from simtip.geometry import Array, Pose
from simtip.rig_file.checks import check_baseline, check_intrinsics, coefficients, rotation
from simtip.rig_file.field import Field
from simtip.rig_file.matrix import read_matrix
from simtip.yaml_file import Document

Size: TypeAlias = tuple[int, int]

REWRITE = "write it with cv2.FileStorage"

CONVENTIONS = (
    "Stereo rig. Lengths in mm; pixel (0, 0) is the centre of the top-left pixel.",
    "OpenCV's convention: p_right = R p_left + T, from left to right camera coordinates.",
    "Camera coordinates: x right, y down, z forward. 1 is the left camera, 2 the right.",
)

_NAMES: dict[str, tuple[str, ...]] = {
    "M1": ("M1", "K1", "cameraMatrix1"),
    "D1": ("D1", "distCoeffs1"),
    "M2": ("M2", "K2", "cameraMatrix2"),
    "D2": ("D2", "distCoeffs2"),
    "R": ("R",),
    "T": ("T",),
}


def rig_from_nodes(document: Document, left: Size | None, right: Size | None) -> StereoRig:
    """Make the rig of a document's nodes; those of other names are ignored.

    Parameters
    ----------
    document
        Matrices as OpenCV's FileStorage writes them, by their names.
    left, right
        (width, height) of the images, px, for a document that does not say.

    Raises
    ------
    InputError
        Whatever is wrong, naming the file, the node and the remedy.
    """
    root = Field.root(document, REWRITE)
    left_size, right_size = _sizes(root, left, right)
    cameras = _camera(root, "1", left_size), _camera(root, "2", right_size)
    T_rl = Pose(_rotation(root), _translation(root))
    return StereoRig(*cameras, T_rl.inverse())


def rig_nodes(rig: StereoRig) -> dict[str, int | Size | Array]:
    """Give the nodes that `rig_from_nodes` reads: sides and sizes in px, matrices (n, m)."""
    nodes: dict[str, int | Size | Array] = {}
    if rig.left.size == rig.right.size:
        nodes |= {"image_width": rig.left.width, "image_height": rig.left.height}
    else:
        nodes |= {"image_size1": rig.left.size, "image_size2": rig.right.size}
    for name, camera in (("1", rig.left), ("2", rig.right)):
        nodes[f"M{name}"] = camera.K
        nodes[f"D{name}"] = np.array([camera.distortion or (0.0,) * 5])
    T_rl = rig.T_lr.inverse()
    return nodes | {"R": T_rl.R, "T": T_rl.t.reshape(3, 1)}


def _node(root: Field, name: str) -> Field:
    """Find a node under any of its names."""
    names = [alias for alias in _NAMES[name] if alias in root.names()]
    if not names:
        raise InputError(
            "the node is missing",
            file=root.document.file,
            field=name,
            remedy=(
                f"add {' or '.join(_NAMES[name])} (OpenCV's sample splits a rig into intrinsics.yml"
                " and extrinsics.yml: put both into one file)"
            ),
        )
    if len(names) > 1:
        raise root.child(names[1]).error(f"stands beside {names[0]}", remedy="keep one of them")
    return root.child(names[0])


def _camera(root: Field, number: str, size: Size) -> Camera:
    matrix = _node(root, f"M{number}")
    K = read_matrix(matrix, (3, 3))
    check_intrinsics(matrix, K)
    distortion = _node(root, f"D{number}")
    return Camera(K, *size, distortion=coefficients(distortion, read_matrix(distortion)))


def _rotation(root: Field) -> Array:
    field = _node(root, "R")
    R = read_matrix(field, (3, 3), (3, 1), (1, 3), (3,))
    if R.size == 3:
        R = np.asarray(cv2.Rodrigues(R.reshape(3, 1))[0], dtype=np.float64)
    return rotation(field, R, "give the R of cv2.stereoCalibrate")


def _translation(root: Field) -> Array:
    field = _node(root, "T")
    T = read_matrix(field, (3, 1), (1, 3), (3,)).ravel()
    check_baseline(field, T)
    return T


def _sizes(root: Field, left: Size | None, right: Size | None) -> tuple[Size, Size]:
    """Give the sizes that the file states, else those of the images."""
    nodes = root.names()
    if "image_width" in nodes or "image_height" in nodes:
        width, height = (root.at(name, nodes.get(name)) for name in ("image_width", "image_height"))
        both = width.side(), height.side()
        return both, both
    left = _listed(root, ("image_size1", "image_size", "imageSize")) or left
    right = _listed(root, ("image_size2", "image_size", "imageSize")) or right
    if left is None or right is None:
        raise root.at("image_width", None).error(
            "the image size is missing", remedy="add image_width and image_height, px"
        )
    return left, right


def _listed(root: Field, names: tuple[str, ...]) -> Size | None:
    name = next((n for n in names if n in root.names()), None)
    return None if name is None else root.child(name).sides()
