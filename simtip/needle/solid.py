"""The needle: a tip on a shaft, straight or bent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from simtip.geometry import Array, Pose, unit
from simtip.needle.bend import Bend, cut_at_levels
from simtip.needle.inside import encloses
from simtip.needle.tip import Faces, Front, Tip, require_positive

if TYPE_CHECKING:
    import trimesh

SEGMENTS = 1024
"""Sides of the polygon that stands for the circle: 3.9 nm off a radius of 0.835 mm at most."""

ROUNDED_SEGMENTS = 512
"""The same for rounded tips, which need more vertices elsewhere: 16 nm."""

BENT_SEGMENTS = 384
"""The same for bent needles, which need hundreds of rings: 28 nm."""

SAGITTA_MM = 4e-4
"""How far the rounding and the bend may stray from their chords: 0.0045 px at the paper's scale."""


@dataclass(frozen=True)
class Needle:
    """A round needle, straight or evenly bent, closed at the hub by a flat face.

    Attributes
    ----------
    diameter_mm, length_mm
        Outer diameter; length along the axis from the foremost point to the hub's end face.
    tip
        The tip's shape, shorter than the needle.
    bend_radius_mm
        Radius of the arc that the axis follows all the way from the tip; None is straight. At
        least 5 diameters, and so large that the needle makes no more than half a turn.
    bend_direction_deg
        Azimuth about z, from +x towards +y, to which the hub is bent.

    Raises
    ------
    ValueError
        A length is not a finite number above zero, the tip does not fit within the needle, or the
        bend is too tight.
    """

    diameter_mm: float
    length_mm: float
    tip: Tip
    bend_radius_mm: float | None = None
    bend_direction_deg: float = 0.0

    def __post_init__(self) -> None:
        require_positive("diameter_mm", self.diameter_mm)
        require_positive("length_mm", self.length_mm)
        self.tip.check(self.radius_mm)
        depth = self.tip.depth_mm(self.radius_mm)
        if not depth < self.length_mm:
            raise ValueError(
                f"the tip is {depth:g} mm long and does not fit in the needle's "
                f"{self.length_mm:g} mm: length_mm has to be above that"
            )
        if self.bend_radius_mm is not None:
            tightest = max(5 * self.diameter_mm, self.length_mm / math.pi)
            if not tightest <= self.bend_radius_mm < math.inf:
                raise ValueError(
                    f"bend_radius_mm has to be at least {tightest:.6g} (5 diameters, and half a "
                    f"turn over the needle's length), not {self.bend_radius_mm:g}"
                )
        if not math.isfinite(self.bend_direction_deg):
            raise ValueError("bend_direction_deg has to be a finite number of degrees")

    @property
    def radius_mm(self) -> float:
        """Half the diameter."""
        return self.diameter_mm / 2

    @property
    def apex(self) -> Array:
        """The tip, (3,) mm, needle frame: the truth that everything is scored against."""
        first: Array = self.apexes[0]
        return first

    @property
    def apexes(self) -> Array:
        """The tip and any other points that are as far forward, (n, 3) mm, needle frame.

        One, but for the Franseen crown's three. Of the blunt end's flat, all of it foremost, only
        the middle is given.
        """
        return self.tip.apexes_mm(self.radius_mm)

    @property
    def bend(self) -> Bend | None:
        """The map from the straight needle, or None."""
        if self.bend_radius_mm is None:
            return None
        return Bend(self.bend_radius_mm, self.bend_direction_deg)

    @property
    def segments(self) -> int:
        """Sides of the circle in `surface`, unless told otherwise."""
        if self.bend_radius_mm is not None:
            return BENT_SEGMENTS
        return ROUNDED_SEGMENTS if self.tip.tip_radius_mm > 0 else SEGMENTS

    def surface(
        self, segments: int | None = None, sagitta_mm: float = SAGITTA_MM
    ) -> tuple[Array, Faces]:
        """Give the closed surface as vertices (n, 3), mm, needle frame, and outward faces (m, 3).

        Every vertex lies on the needle's surface (of a bent needle's tip: to within `sagitta_mm`).
        Ring vertices lie on the circle of the stated diameter, so a straight needle's solid is
        inscribed: its silhouette is narrow by at most ``R (1 - cos(pi / segments))`` a side, and
        by `sagitta_mm` where it is rounded. A bent one's strays by the sum of both, either way.
        The apexes are among the vertices, and so are the shaft's points at x = +-R and y = +-R.

        The arrays are shared between calls and cannot be written to.

        Parameters
        ----------
        segments
            Sides of the circle, a multiple of 4, at least 8; the points where edges of the tip
            meet the shaft come on top. By default the needle's own number of `segments`.
        sagitta_mm
            How far arcs of the bend and of the rounding may stray from their chords.

        Raises
        ------
        ValueError
            `segments` is below 8 or no multiple of 4, or `sagitta_mm` is not above 0.
        """
        if segments is None:
            segments = self.segments
        if segments < 8 or segments % 4:
            raise ValueError(f"segments has to be a multiple of 4, at least 8, not {segments}")
        require_positive("sagitta_mm", sagitta_mm)
        return _surface(self, segments, sagitta_mm)

    def mesh(self, segments: int | None = None) -> trimesh.Trimesh:
        """Build the watertight `trimesh.Trimesh` of `surface`: mm, needle frame, outward faces."""
        import trimesh

        vertices, faces = self.surface(segments)
        return trimesh.Trimesh(vertices.copy(), faces.copy(), process=False)

    def core(self, segments: int | None = None) -> Array:
        """Give points (n, 3), mm, needle frame, whose balls of the tip radius make up the front.

        Exact for a straight needle with `segments` sides. A bent one's balls are taken as round,
        which they are to within r R / (bend radius).
        """
        points = self.tip.core_mm(self.radius_mm, self.segments if segments is None else segments)
        return points if self.bend is None else self.bend.apply(points)

    def encloses(self, point: ArrayLike) -> bool:
        """Say whether a point (3,) mm, needle frame, is inside the needle's solid."""
        p = np.asarray(point, dtype=np.float64)
        x, y, z = p if self.bend is None else self.bend.undo(p)
        if math.hypot(x, y) > self.radius_mm or not 0 <= z <= self.length_mm:
            return False  # quickly, for nearly every point
        return encloses(*self.surface(), p)

    def pose(self, apex_mm: ArrayLike, axis: ArrayLike, roll_deg: float = 0.0) -> Pose:
        """Give T_wn, which puts the apex at a point and the needle's z along an axis.

        At roll 0 the needle's x axis is world +x less its part along the axis (world +z takes the
        place of +x within 0.6 degrees of it), so for the default axis (0, -1, 0) the needle's
        x, y, z are world +x, +z, -y, and they turn smoothly with the axis around there.

        Parameters
        ----------
        apex_mm
            (3,) mm, world.
        axis
            (3,) from the tip to the hub, world, any length; of a bent needle the tangent at the
            tip.
        roll_deg
            Right-handed turn about the axis, degrees.

        Raises
        ------
        ValueError
            The axis has no length.
        """
        z = unit(axis)
        reference = np.array([1.0, 0, 0]) if abs(z[0]) < math.cos(0.01) else np.array([0, 0, 1.0])
        x0 = unit(reference - (reference @ z) * z)
        y0 = np.cross(z, x0)
        roll = math.radians(roll_deg)
        x = math.cos(roll) * x0 + math.sin(roll) * y0
        R = np.stack([x, np.cross(z, x), z], axis=1)
        return Pose(R, np.asarray(apex_mm, dtype=np.float64) - R @ self.apex)


@lru_cache(maxsize=16)
def _surface(needle: Needle, segments: int, sagitta_mm: float) -> tuple[Array, Faces]:
    front = needle.tip.front(needle.radius_mm, segments, sagitta_mm)
    bend = needle.bend
    if bend is None:
        vertices, faces = _closed(front, np.array([needle.length_mm]))
    else:
        levels = bend.levels(needle.length_mm, needle.radius_mm, sagitta_mm)
        behind = levels > float(front.rim_z.max()) + 1e-6
        behind[-1] = True
        vertices, faces = _closed(front, levels[behind])
        deepest = max(float(front.rim_z.max()), float(front.points[:, 2].max()))
        vertices, faces = cut_at_levels(vertices, faces, levels[(levels > 0) & (levels < deepest)])
        vertices = bend.apply(vertices)
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces


def _closed(front: Front, levels: Array) -> tuple[Array, Faces]:
    """Add the shaft, with a ring of points at each level, and the hub's face at the last."""
    n = len(front.ring)
    here, after = np.arange(n), np.roll(np.arange(n), -1)
    base = n + len(front.points)  # rim, points of the front, rings, hub's centre
    starts = [0, *(base + n * np.arange(len(levels)))]
    rings = [np.column_stack([front.ring, np.full(n, z)]) for z in levels]
    hub = starts[-1]
    centre = np.full(n, hub + n)
    sides = []
    for a, b in pairwise(starts):
        sides += [
            np.stack([a + here, a + after, b + after], axis=1),
            np.stack([a + here, b + after, b + here], axis=1),
        ]
    vertices = np.concatenate(
        [
            np.column_stack([front.ring, front.rim_z]),
            front.points,
            *rings,
            [[0.0, 0.0, levels[-1]]],
        ]
    )
    cap = np.stack([centre, hub + here, hub + after], axis=1)
    return vertices, np.concatenate([front.faces, *sides, cap])
