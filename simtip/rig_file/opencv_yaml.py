"""OpenCV FileStorage YAML, written as every version of OpenCV since 3 reads it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.rig_file.exact import listed
from simtip.rig_file.opencv import CONVENTIONS, rig_nodes


def opencv_yaml_text(rig: StereoRig) -> str:
    """Write a rig as OpenCV FileStorage YAML."""
    lines: list[str] = []
    for name, node in rig_nodes(rig).items():
        if isinstance(node, int):
            lines.append(f"{name}: {node}")
        elif isinstance(node, tuple):
            lines.append(f"{name}: [ {node[0]}, {node[1]} ]")
        else:
            lines += matrix_lines(name, node)
    return storage_text(CONVENTIONS, lines)


def storage_text(comments: Iterable[str], lines: Iterable[str]) -> str:
    """Give a file's text: comments, then lines of its nodes."""
    # OpenCV 3 and 4 accept no other first line.
    return "\n".join(["%YAML:1.0", "---", *(f"# {line}" for line in comments), *lines]) + "\n"


def matrix_lines(name: str, matrix: Array) -> list[str]:
    """Write a matrix (rows, columns), or (rows, columns, channels), of doubles as a node."""
    rows, columns = matrix.shape[:2]
    channels = "" if matrix.ndim == 2 else str(matrix.shape[2])
    flat = np.reshape(matrix, (rows, -1))
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {columns}",
        f'   dt: "{channels}d"' if channels else "   dt: d",
        "   data: [ " + ",\n       ".join(listed(row) for row in flat) + " ]",
    ]
