"""Tips that grinding planes leave, sharp or rounded: what all of them share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from simtip.geometry import Array
from simtip.needle.planes import Facets, Planes, facets_over_annulus, facets_over_disc
from simtip.needle.skin import Skin, skin
from simtip.needle.tip import Faces, Front, arc_steps, on_circle, require_rounding


@dataclass(frozen=True)
class GroundTip(ABC):
    """A round bar, or a tube, less what one or more ground planes take away.

    Subclasses say which planes, and where the inner front (see `simtip.needle.skin`) is foremost.
    """

    kind: ClassVar[str]

    @property
    @abstractmethod
    def tip_radius_mm(self) -> float:
        """Radius of every edge and corner of the tip, mm; 0 is sharp."""

    @abstractmethod
    def planes(self, radius_mm: float) -> Planes:
        """Give the sharp tip's planes; where they lie along z is free."""

    @abstractmethod
    def foremost(self, radius_mm: float) -> Array:
        """Give x and y (n, 2) of the foremost points; the first is the tip."""

    def bore_mm(self, radius_mm: float) -> float:  # noqa: ARG002 - for a subclass to use
        """Give the bore's radius; 0 for a bar."""
        return 0.0

    def bore_depth_mm(self, radius_mm: float) -> float:  # noqa: ARG002 - as above
        """Give how far the bore reaches beyond the ground part."""
        return 0.0

    def check(self, radius_mm: float) -> None:
        """Raise ValueError where the rounding does not fit into the shaft."""
        require_rounding(self.kind, self.tip_radius_mm, radius_mm, "the needle's radius")

    def inner(self, radius_mm: float) -> Planes:
        """Give the planes that the balls' centres keep to; the front's foremost point is at r."""
        r = self.tip_radius_mm
        planes = self.planes(radius_mm).moved(r)
        return planes.moved(0, r - float(planes.over(self.foremost(radius_mm))[0]))

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to where the full cylinder begins."""
        return self.inner(radius_mm).highest(radius_mm - self.tip_radius_mm)

    def depth_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to the floor of the bore, if there is one."""
        return self.extent_mm(radius_mm) + self.bore_depth_mm(radius_mm)

    def apexes_mm(self, radius_mm: float) -> Array:
        """Give the foremost points, (n, 3), needle frame; the first is the tip."""
        xy = self.foremost(radius_mm)
        return np.column_stack([xy, np.zeros(len(xy))])

    def core_mm(self, radius_mm: float, segments: int) -> Array:
        """Give the inner front's corners and rims, (n, 3): the rest lies between them."""
        return self._facets(radius_mm, segments).points

    def front(self, radius_mm: float, segments: int, sagitta_mm: float) -> Front:
        """Build the ground surface, its rounded edges, and the bore."""
        facets, planes = self._facets(radius_mm, segments), self.inner(radius_mm)
        r = self.tip_radius_mm
        widest = np.pi / 2 + float(np.arcsin(np.abs(planes.normals[:, :2]).max()))
        off = facets.points[:, None, :2] - self.foremost(radius_mm)[None]
        ahead = np.flatnonzero((np.linalg.norm(off, axis=2) < 1e-9 * radius_mm).any(axis=1))
        surface = skin(facets, planes, r, arc_steps(r, widest, sagitta_mm), ahead)
        n = len(facets.angles)
        vertices, faces = surface.vertices, surface.faces
        if facets.rims > n:
            vertices, faces = self._bored(surface, n, radius_mm)
        ring = on_circle(facets.angles, radius_mm)
        return Front(ring, vertices[:n, 2], vertices[n:], faces)

    def _facets(self, radius_mm: float, segments: int) -> Facets:
        planes, r, bore = self.inner(radius_mm), self.tip_radius_mm, self.bore_mm(radius_mm)
        if bore > 0:
            return facets_over_annulus(planes, radius_mm - r, bore + r, segments)
        return facets_over_disc(planes, radius_mm - r, segments)

    def _bored(self, surface: Skin, n: int, radius_mm: float) -> tuple[Array, Faces]:
        """Add the bore's wall and floor behind the inner rim, vertices n to 2 n - 1."""
        depth = self.depth_mm(radius_mm)
        wall = surface.vertices[n : 2 * n].copy()
        wall[:, 2] = depth
        count = len(surface.vertices)
        here, after = n + np.arange(n), n + np.roll(np.arange(n), -1)
        floor_here, floor_after = count + np.arange(n), count + np.roll(np.arange(n), -1)
        centre = np.full(n, count + n)
        vertices = np.concatenate([surface.vertices, wall, [[0.0, 0.0, depth]]])
        faces = np.concatenate(
            [
                surface.faces,
                np.stack([after, here, floor_here], axis=1),
                np.stack([after, floor_here, floor_after], axis=1),
                np.stack([centre, floor_after, floor_here], axis=1),
            ]
        )
        return vertices, faces
