"""OpenCV FileStorage YAML, written as every version of OpenCV since 3 reads it."""

from __future__ import annotations

from simtip.camera import StereoRig
from simtip.geometry import Array
from simtip.rig_file.exact import listed
from simtip.rig_file.opencv import CONVENTIONS, rig_nodes


def opencv_yaml_text(rig: StereoRig) -> str:
    """Write a rig as OpenCV FileStorage YAML."""
    # OpenCV 3 and 4 accept no other first line.
    lines = ["%YAML:1.0", "---", *(f"# {line}" for line in CONVENTIONS)]
    for name, node in rig_nodes(rig).items():
        if isinstance(node, int):
            lines.append(f"{name}: {node}")
        elif isinstance(node, tuple):
            lines.append(f"{name}: [ {node[0]}, {node[1]} ]")
        else:
            lines += _matrix_lines(name, node)
    return "\n".join(lines) + "\n"


def _matrix_lines(name: str, matrix: Array) -> list[str]:
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {matrix.shape[0]}",
        f"   cols: {matrix.shape[1]}",
        "   dt: d",
        "   data: [ " + ",\n       ".join(listed(row) for row in matrix) + " ]",
    ]
