"""Matrices as OpenCV's FileStorage and ROS write them: rows, cols and all entries in one list."""

from __future__ import annotations

import math

from simtip.geometry import Array
from simtip.rig_file.field import MAX_MAGNITUDE, MAX_SIDE, Field
from simtip.yaml_file import Yaml, shown

_DEPTHS = frozenset("ucwsifdh")


def read_matrix(
    field: Field, *shapes: tuple[int, ...], typed: bool = True, limit: float = MAX_MAGNITUDE
) -> Array:
    """Read a matrix of one channel, with one or two dimensions, of finite numbers.

    Parameters
    ----------
    field
        A mapping of ``rows``, ``cols`` (or ``sizes``), ``data`` and ``dt``.
    shapes
        The shapes accepted, the usual one first; any by default.
    typed
        Whether it has to have ``dt``, the type of OpenCV's entries; ROS writes none.
    limit
        Largest magnitude of an entry.

    Raises
    ------
    InputError
        Whatever is wrong with it.
    """
    node = field.value
    if not isinstance(node, dict):
        raise field.error(f"is no matrix but {shown(node)}")
    needed = ["data"] if "sizes" in node else ["rows", "cols", "data"]
    for key in (*needed, "dt") if typed else needed:
        if key not in node:
            raise field.error(f"the matrix has no '{key}'")
    if typed:
        _check_type(field.child("dt"))
    shape = _shape(field, node)
    data = field.child("data")
    entries = data.numbers(limit)
    if len(entries) != math.prod(shape):
        raise data.error(
            f"has {len(entries)} entries for {' x '.join(map(str, shape))}",
            remedy="correct rows, cols or data",
        )
    if shapes and shape not in shapes:
        found, wanted = (" x ".join(map(str, each)) for each in (shape, shapes[0]))
        raise field.error(f"is {found}", remedy=f"it has to be {wanted}")
    return entries.reshape(shape)


def _check_type(dt: Field) -> None:
    if not isinstance(dt.value, str) or dt.value.removeprefix("1") not in _DEPTHS:
        raise dt.error(
            f"is {shown(dt.value)}, not the type of a matrix with one channel",
            remedy="write it as dt: d",
        )


def _shape(field: Field, node: dict[str, Yaml]) -> tuple[int, ...]:
    # An nd-matrix, which OpenCV 5 writes for an array of one dimension, has sizes instead.
    sizes = node.get("sizes", [node.get("rows"), node.get("cols")])
    if isinstance(sizes, list) and len(sizes) in {1, 2}:
        shape = tuple(n for n in sizes if type(n) is int and 0 <= n <= MAX_SIDE)
        if len(shape) == len(sizes):
            return shape
    raise field.child("sizes" if "sizes" in node else "rows").error("is not the shape of a matrix")
