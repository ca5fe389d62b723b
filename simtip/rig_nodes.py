"""The nodes of a rig file: OpenCV FileStorage YAML to matrices of finite numbers.

Files are read by `simtip.yaml_file`, not by OpenCV's own parser: that one is not made for hostile
input.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.input_file import read_bytes
from simtip.yaml_file import Document, FieldPath, Yaml, parse_yaml, shown

MAX_BYTES = 1024 * 1024
"""Largest rig file read: room for the views of a calibration beside the matrices."""
MAX_MAGNITUDE = 1e8
"""Largest focal length, principal point (px), coefficient and baseline (mm) taken seriously."""
MAX_SIDE = 65535
"""Largest image side, px."""

_NAMES: dict[str, tuple[str, ...]] = {
    "M1": ("M1", "K1", "cameraMatrix1"),
    "D1": ("D1", "distCoeffs1"),
    "M2": ("M2", "K2", "cameraMatrix2"),
    "D2": ("D2", "distCoeffs2"),
    "R": ("R",),
    "T": ("T",),
}
_DEPTHS = frozenset("ucwsifdh")
REWRITE = "write it with cv2.FileStorage"


def load_nodes(path: str | Path) -> Document:
    """Read the file as a mapping of nodes."""
    data = read_bytes(path, MAX_BYTES)
    start = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    form = {b"<": "XML", b"{": "JSON"}.get(start)
    if form is not None:
        raise InputError(
            f"is {form}, which is not read yet",
            file=path,
            remedy="write the rig with cv2.FileStorage to a file that ends in .yml",
        )
    document = parse_yaml(data, path, opencv=True)
    if not isinstance(document.value, dict):
        raise document.error(f"a rig has named nodes, not {shown(document.value)}", remedy=REWRITE)
    return document


def _node(document: Document, name: str) -> tuple[FieldPath, Yaml]:
    """Find a node under any of its names."""
    nodes = document.value if isinstance(document.value, dict) else {}
    names = [alias for alias in _NAMES[name] if alias in nodes]
    if not names:
        raise InputError(
            "the node is missing",
            file=document.file,
            field=name,
            remedy=(
                f"add {' or '.join(_NAMES[name])} (OpenCV's sample splits a rig into intrinsics.yml"
                " and extrinsics.yml: put both into one file)"
            ),
        )
    if len(names) > 1:
        raise document.error(f"stands beside {names[0]}", (names[1],), remedy="keep one of them")
    return (names[0],), nodes[names[0]]


def read_matrix(document: Document, name: str, *shapes: tuple[int, ...]) -> tuple[FieldPath, Array]:
    """Read a matrix of one channel, with one or two dimensions, of finite numbers.

    Parameters
    ----------
    document
        From `load_nodes`.
    name
        A name of `cv2.stereoCalibrate`'s sample, e.g. ``M1``; its aliases are tried too.
    shapes
        The shapes accepted, the usual one first; any by default.

    Returns
    -------
    path, matrix
        Where the node stands, for messages, and its numbers.

    Raises
    ------
    InputError
        Whatever is wrong with the node.
    """
    path, node = _node(document, name)
    if not isinstance(node, dict):
        raise document.error(f"is no matrix but {shown(node)}", path, remedy=REWRITE)
    for key in ("dt", "data") if "sizes" in node else ("rows", "cols", "dt", "data"):
        if key not in node:
            raise document.error(f"the matrix has no '{key}'", path, remedy=REWRITE)
    dt = node["dt"]
    if not isinstance(dt, str) or dt.removeprefix("1") not in _DEPTHS:
        raise document.error(
            f"is {shown(dt)}, not the type of a matrix with one channel",
            (*path, "dt"),
            remedy="write it as dt: d",
        )
    shape = _shape(document, path, node)
    entries = _entries(document, path, node["data"])
    if len(entries) != math.prod(shape):
        raise document.error(
            f"has {len(entries)} entries for {' x '.join(map(str, shape))}",
            (*path, "data"),
            remedy="correct rows, cols or data",
        )
    if shapes and shape not in shapes:
        found, wanted = (" x ".join(map(str, each)) for each in (shape, shapes[0]))
        raise document.error(f"is {found}", path, remedy=f"it has to be {wanted}")
    return path, entries.reshape(shape)


def _shape(document: Document, path: FieldPath, node: dict[str, Yaml]) -> tuple[int, ...]:
    # An nd-matrix, which OpenCV 5 writes for an array of one dimension, has sizes instead.
    sizes = node.get("sizes", [node.get("rows"), node.get("cols")])
    if isinstance(sizes, list) and len(sizes) in {1, 2}:
        shape = tuple(n for n in sizes if type(n) is int and 0 <= n <= MAX_SIDE)
        if len(shape) == len(sizes):
            return shape
    key = "sizes" if "sizes" in node else "rows"
    raise document.error("is not the shape of a matrix", (*path, key), remedy=REWRITE)


def _entries(document: Document, path: FieldPath, data: Yaml) -> Array:
    path = (*path, "data")
    if not isinstance(data, list):
        raise document.error(
            f"has to be a list of numbers, not {shown(data)}", path, remedy=REWRITE
        )
    entries = np.empty(len(data))
    for index, entry in enumerate(data):
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            raise document.error(f"is {shown(entry)}, not a number", (*path, index), remedy=REWRITE)
        # Written this way round, NaN fails too.
        if not abs(entry) <= MAX_MAGNITUDE:
            raise document.error(
                f"is {shown(entry)}, which no rig has",
                (*path, index),
                remedy="calibrate again or correct it",
            )
        entries[index] = entry
    return entries
