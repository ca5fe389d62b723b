"""Mesh files of needles, STL and PLY: untrusted data."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from simtip.errors import InputError
from simtip.input_file import read_bytes
from simtip.refine.generate import FORMS, named
from simtip.refine.solid import Solid

KINDS = ("ply", "stl")
MAX_BYTES = 1 << 26
MAX_FACES = 500_000


def read_solid(path: str | Path) -> Solid:
    """Read a needle's mesh.

    Parameters
    ----------
    path
        An STL or PLY file, text or binary; mm, z along the axis from the tip to the hub, the axis
        at x = y = 0. The apex is the middle of the foremost vertices.

    Raises
    ------
    InputError
        It is no such file, damaged, too large, or its mesh is no straight, convex needle; it names
        the file.
    """
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in KINDS:
        raise InputError("is neither .ply nor .stl", file=path, remedy=f"give a mesh, or {FORMS}")
    data = read_bytes(path, MAX_BYTES)
    import trimesh

    try:
        mesh = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh", process=False)
        vertices = np.asarray(mesh.vertices, np.float64).reshape(-1, 3)
        faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
    except Exception as error:  # its parsers raise whatever garbage makes them run into
        problem = f"cannot be read as {kind.upper()} ({type(error).__name__})"
        raise InputError(problem, file=path, remedy="save it again, or copy it again") from error
    if len(faces) > MAX_FACES:
        raise InputError(
            f"has {len(faces)} faces, more than {MAX_FACES}", file=path, remedy="reduce the mesh"
        )
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise InputError("has a face whose corner is no vertex", file=path, remedy="save it again")
    try:
        return Solid.from_mesh(vertices, faces)
    except InputError as error:
        raise InputError(error.problem, file=path, remedy=error.remedy) from error


def solid_of(text: str) -> Solid:
    """Give the needle that a text names, in one of `FORMS` or by a mesh file.

    Raises
    ------
    InputError
        See `read_solid` and `simtip.refine.generate.named`.
    """
    if text.partition(":")[0].strip() in ("cone", "bevel"):
        return named(text)
    return read_solid(text)
