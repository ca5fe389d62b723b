"""Triangle meshes, from arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from simtip.geometry import Array
from simtip.needle import Faces
from simtip.render.engine import mi


def mesh_of(name: str, vertices: Array, faces: Faces, parts: dict[str, Any]) -> Any:
    """Load a mesh with its material (and light). Its faces are flat."""
    props = mi.Properties()
    for key, part in parts.items():
        props[key] = mi.load_dict(part) if isinstance(part, dict) else part
    shape = mi.Mesh(name, len(vertices), len(faces), props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = np.ascontiguousarray(vertices, dtype=np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(faces, dtype=np.uint32).ravel()
    parameters.update()
    return shape
