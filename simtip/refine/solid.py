"""The known shape of a needle: what of a mesh its pictures depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.errors import InputError
from simtip.geometry import Array
from simtip.refine.facets import Facet, forward, planar

Faces = NDArray[np.int64]

HOLLOW = 0.01
"""Share of its convex hull that a solid may lack."""

ON_AXIS = 0.02
"""Of the radius: how far the shaft's middle may lie off the needle's axis."""

ROUND = 2e-3
"""Of the radius: how uneven a body of revolution may be."""

DIRECTIONS = 23
"""Each way, in which its evenness is tried."""

CURVED_SHARE = 0.3
"""Of the tip's surface: where less lies in no facet, it is their rounded edges."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A straight convex needle, in its own frame: z along the axis from the tip to the hub, mm.

    Build one with `from_mesh`.

    Attributes
    ----------
    front
        (n, 3) mm, corners of the solid, but for the hub's end.
    ring
        (m, 2) mm, corners x, y of the shaft's cross-section, a convex polygon.
    apex
        (3,) mm, the point that is measured.
    facets
        The planes ground into the tip, if any.
    depth_mm
        z at which the tip ends and the shaft is whole.
    length_mm
        z of the hub's end.
    curved
        The front has surface that is neither shaft nor facet, as a cone's.
    revolution
        Turning it about its axis changes nothing.
    """

    front: Array
    ring: Array
    apex: Array
    facets: tuple[Facet, ...]
    depth_mm: float
    length_mm: float
    curved: bool
    revolution: bool

    @property
    def radius_mm(self) -> float:
        """Of the shaft, that is of the circle about its cross-section."""
        return float(np.linalg.norm(self.ring, axis=1).max())

    @classmethod
    def from_mesh(cls, vertices: Array, faces: Faces, apex: Array | None = None) -> Solid:
        """Take what is needed from a closed mesh.

        Parameters
        ----------
        vertices
            (n, 3) mm: z along the axis from the tip to the hub, the axis at x = y = 0. They are
            moved along z so that the foremost is at 0.
        faces
            (k, 3) corners of triangles, counter-clockwise seen from outside.
        apex
            (3,) mm, in the frame of `vertices`; by default the middle of the foremost vertices.

        Raises
        ------
        InputError
            It is no straight, convex needle along z.
        """
        points = np.array(vertices, np.float64)
        _require_solid(points, faces)
        start = float(points[:, 2].min())
        points[:, 2] -= start
        length = float(points[:, 2].max())
        ring = points[scipy.spatial.ConvexHull(points[:, :2]).vertices, :2]
        radius = float(np.linalg.norm(ring, axis=1).max())
        _require_needle(points, faces, radius, length)
        first = points[points[:, 2] <= 1e-6 * radius]
        tip = first.mean(axis=0) if apex is None else np.asarray(apex, np.float64) - [0, 0, start]
        corners = points[scipy.spatial.ConvexHull(points).vertices]
        front = corners[corners[:, 2] < length * (1 - 1e-6)]
        facing = forward(points, faces)
        depth = float(points[faces[facing], 2].max()) if facing.any() else 0.0
        facets, curved = planar(points, faces[facing], radius)
        return cls(
            front,
            ring,
            tip,
            facets,
            depth,
            length,
            curved > CURVED_SHARE,
            _is_revolution(front, radius, tip),
        )


def _require_solid(points: Array, faces: Faces) -> None:
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 8 or len(faces) < 8:
        raise InputError("is no mesh of a needle: it has too few vertices or faces")
    if not np.isfinite(points).all():
        raise InputError("has a vertex that is not finite")


def _require_needle(points: Array, faces: Faces, radius: float, length: float) -> None:
    frame = "z along the axis from the tip to the hub, the axis at x = y = 0, in mm"
    if length < 4 * radius:
        raise InputError(
            f"is {length:.4g} mm long along z and {2 * radius:.4g} mm thick: no needle along z",
            remedy=f"turn the mesh: {frame}",
        )
    hub = points[points[:, 2] > length * (1 - 1e-6)]
    off = float(np.linalg.norm((hub.max(axis=0) + hub.min(axis=0))[:2] / 2))
    if off > ON_AXIS * radius:
        raise InputError(
            f"has its hub's middle {off:.3g} mm off the z axis: bent, or in another frame",
            remedy=f"straight needles only; {frame}",
        )
    wide = float(np.linalg.norm(hub[:, :2], axis=1).max())
    if wide < (1 - ON_AXIS) * radius:
        raise InputError(
            f"is {2 * wide:.4g} mm thick at the hub's end and {2 * radius:.4g} mm elsewhere",
            remedy=f"is the tip at the small end of z, and the hub cut off? {frame}",
        )
    a, b, c = (points[faces[:, k]] for k in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    try:
        hull = float(scipy.spatial.ConvexHull(points).volume)
    except scipy.spatial.QhullError as error:
        raise InputError("is flat: it has no volume") from error
    if not (1 - HOLLOW) * hull < volume < (1 + HOLLOW) * hull:
        raise InputError(
            f"is not convex, not closed, or inside out: its faces enclose {volume:.4g} mm^3, its "
            f"convex hull {hull:.4g} mm^3",
            remedy="solid convex needles only: close a bore, turn the faces outwards",
        )


def _is_revolution(front: Array, radius: float, apex: Array) -> bool:
    """Tell whether turning the needle about its axis changes nothing, by how far it reaches."""
    steep, azimuth = np.meshgrid(
        np.linspace(0, np.pi / 2, DIRECTIONS), 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    )
    d = [np.sin(steep) * np.cos(azimuth), np.sin(steep) * np.sin(azimuth), -np.cos(steep)]
    reach = (np.stack(d, axis=-1) @ front.T).max(axis=-1)
    on_axis = np.linalg.norm(apex[:2]) <= ROUND * radius
    return bool(on_axis and np.ptp(reach, axis=0).max() <= ROUND * radius)
