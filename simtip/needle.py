"""The needle's geometry, and the one definition of its tip.

Needle frame, mm: z runs along the axis from the tip to the hub, the axis is x = y = 0, the
foremost point of the solid has z = 0 and the hub's end face z = length. The **tip** is the apex:
one 3-D point of the solid, `Needle.apex`. What a camera sees foremost, the extreme point of the
silhouette, is another thing for bevelled and rounded tips: `silhouette_tip` gives that one.

A new kind of tip is a frozen dataclass with the three methods of `Tip`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array, Pose, unit

if TYPE_CHECKING:
    import trimesh

    from simtip.camera import Camera

Faces = NDArray[np.int64]

SEGMENTS = 1024
"""Sides of the polygon that stands for the circle: 3.9 nm off a radius of 0.835 mm at most."""

NEAR_MM = 1.0
"""Nothing closer to a camera's centre plane than this is taken to be seen."""

FOOTPRINT_SEGMENTS = 128


@dataclass(frozen=True, eq=False)
class Front:
    """The surface that closes the needle towards the tip.

    Attributes
    ----------
    rim_z
        (n,) mm, where the cylinder's generator through each point of the ring begins.
    points
        (m, 3) mm, further vertices of the surface.
    faces
        (k, 3), outward; 0 to n - 1 are the rim, n and above are `points`.
    """

    rim_z: Array
    points: Array
    faces: Faces


class Tip(Protocol):
    """What `Needle` needs to know of a kind of tip, a dataclass; radii in mm."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length from the foremost point to where the full cylinder begins."""

    def apex_mm(self, radius_mm: float) -> Array:
        """Give the tip, (3,), needle frame."""

    def front(self, ring: Array, radius_mm: float) -> Front:
        """Build the surface over a ring (n, 2) of points on the circle, counter-clockwise."""


def _fan(rim_z: Array, centre: ArrayLike) -> Front:
    """Join a rim to one point."""
    n = len(rim_z)
    here = np.arange(n)
    faces = np.stack([np.full(n, n), np.roll(here, -1), here], axis=1)
    return Front(rim_z, np.array([centre], dtype=np.float64), faces)


@dataclass(frozen=True)
class Cone:
    """A cone on the axis; the tip is its apex, the origin.

    Attributes
    ----------
    length_mm
        From the apex to the full diameter.
    """

    length_mm: float

    def __post_init__(self) -> None:
        _require_positive("the cone's length_mm", self.length_mm)

    def extent_mm(self, radius_mm: float) -> float:  # noqa: ARG002 - the protocol's signature
        """Give the cone's length."""
        return self.length_mm

    def apex_mm(self, radius_mm: float) -> Array:  # noqa: ARG002 - the protocol's signature
        """Give the origin."""
        return np.zeros(3)

    def front(self, ring: Array, radius_mm: float) -> Front:  # noqa: ARG002 - as above
        """Build the cone's side."""
        return _fan(np.full(len(ring), self.length_mm), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Bevel:
    """A single plane cut: the solid is ``z >= (R - x) / tan(angle)``, so the tip is (R, 0, 0).

    Attributes
    ----------
    angle_deg
        Between the cut plane and the axis: 90 would be a blunt end.
    """

    angle_deg: float

    def __post_init__(self) -> None:
        if not 0 < self.angle_deg < 90:
            raise ValueError(
                f"the bevel's angle_deg has to lie between 0 and 90, not {self.angle_deg:g}"
            )

    def extent_mm(self, radius_mm: float) -> float:
        """Give the length of the cut, seen from the side."""
        return 2 * radius_mm / math.tan(math.radians(self.angle_deg))

    def apex_mm(self, radius_mm: float) -> Array:
        """Give the foremost point of the cut."""
        return np.array([radius_mm, 0.0, 0.0])

    def front(self, ring: Array, radius_mm: float) -> Front:
        """Build the flat, elliptic cut."""
        slope = 1 / math.tan(math.radians(self.angle_deg))
        return _fan((radius_mm - ring[:, 0]) * slope, (0.0, 0.0, radius_mm * slope))


@dataclass(frozen=True)
class Needle:
    """A straight, solid, round needle, closed at the hub by a flat face.

    Attributes
    ----------
    diameter_mm, length_mm
        Outer diameter; length from the foremost point to the hub's end face.
    tip
        The tip's shape, shorter than the needle.

    Raises
    ------
    ValueError
        A length is not a finite number above zero, or the tip does not fit within the length.
    """

    diameter_mm: float
    length_mm: float
    tip: Tip

    def __post_init__(self) -> None:
        _require_positive("diameter_mm", self.diameter_mm)
        _require_positive("length_mm", self.length_mm)
        extent = self.tip.extent_mm(self.radius_mm)
        if not extent < self.length_mm:
            raise ValueError(
                f"the tip is {extent:g} mm long and does not fit in the needle's "
                f"{self.length_mm:g} mm"
            )

    @property
    def radius_mm(self) -> float:
        """Half the diameter."""
        return self.diameter_mm / 2

    @property
    def apex(self) -> Array:
        """The tip, (3,) mm, needle frame: the truth that everything is scored against."""
        return self.tip.apex_mm(self.radius_mm)

    def surface(self, segments: int = SEGMENTS) -> tuple[Array, Faces]:
        """Give the closed surface as vertices (n, 3), mm, needle frame, and outward faces (m, 3).

        Ring vertices lie on the circle of the stated diameter, so the solid is inscribed: its
        silhouette is narrow by at most ``R (1 - cos(pi / segments))`` a side. The apex, and the
        points at x = +-R and y = +-R, are among the vertices.

        Raises
        ------
        ValueError
            `segments` is below 8 or no multiple of 4.
        """
        if segments < 8 or segments % 4:
            raise ValueError(f"segments has to be a multiple of 4, at least 8, not {segments}")
        angle = 2 * np.pi * np.arange(segments) / segments
        ring = self.radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        front = self.tip.front(ring, self.radius_mm)
        here, after = np.arange(segments), np.roll(np.arange(segments), -1)
        hub = segments + len(front.points)  # rim, points of the front, hub's ring, hub's centre
        centre = np.full(segments, hub + segments)
        vertices = np.concatenate(
            [
                np.column_stack([ring, front.rim_z]),
                front.points,
                np.column_stack([ring, np.full(segments, self.length_mm)]),
                [[0.0, 0.0, self.length_mm]],
            ]
        )
        faces = np.concatenate(
            [
                front.faces,
                np.stack([here, after, hub + after], axis=1),
                np.stack([here, hub + after, hub + here], axis=1),
                np.stack([centre, hub + here, hub + after], axis=1),
            ]
        )
        return vertices, faces

    def mesh(self, segments: int = SEGMENTS) -> trimesh.Trimesh:
        """Build the watertight `trimesh.Trimesh` of `surface`: mm, needle frame, outward faces."""
        import trimesh

        vertices, faces = self.surface(segments)
        return trimesh.Trimesh(vertices, faces, process=False)

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
            (3,) from the tip to the hub, world, any length.
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


def projected_axis(needle: Needle, T_cn: Pose, camera: Camera) -> Array:
    """Give the image direction from the tip towards the hub, at the tip: (2,), unit length.

    It is the derivative of the projection at the apex along the axis, so it holds with distortion.

    Parameters
    ----------
    needle
        The needle.
    T_cn
        Maps the needle's frame to the camera's.
    camera
        The camera.

    Raises
    ------
    ValueError
        The apex is not in front of the camera, or the needle points straight at it.
    """
    apex = T_cn.apply(needle.apex)
    if not apex[2] > 0:
        raise ValueError("the tip is not in front of the camera")
    distortion = np.asarray(camera.distortion) if camera.distortion else np.zeros(4)
    # The derivative by the translation (columns 3 to 5) is the derivative by the point.
    _, jacobian = cv2.projectPoints(
        apex.reshape(1, 1, 3), np.zeros(3), np.zeros(3), camera.K, distortion
    )
    along = np.asarray(jacobian, dtype=np.float64)[:, 3:6] @ T_cn.R[:, 2]
    scale = max(camera.K[0, 0], camera.K[1, 1]) / apex[2]
    if not np.linalg.norm(along) > 1e-9 * scale:
        raise ValueError(
            "the needle points straight at the camera: its axis has no direction there"
        )
    return unit(along)


def silhouette_tip(needle: Needle, T_cn: Pose, camera: Camera, segments: int = SEGMENTS) -> Array:
    """Give the foremost point of the needle's image, (2,) px, occluded or not.

    Foremost is furthest against `projected_axis`. A vertex is always foremost in a pinhole's
    image, so the result is exact for the polygonal needle of `segments`; on the round needle the
    point lies as far forward to within `Needle.surface`'s silhouette error, and, where the outline
    is round there, up to half a segment (``pi R / segments``) to the side.

    Raises
    ------
    ValueError
        As `projected_axis`.
    """
    backward = projected_axis(needle, T_cn, camera)
    vertices, _ = needle.surface(segments)
    points = T_cn.apply(vertices)
    in_front = points[points[:, 2] > NEAR_MM]
    pixels = camera.project(in_front)
    if camera.distortion and len(
        pixels
    ):  # beyond the field of view the model may fold back into the image
        direction = in_front[:, :2] / in_front[:, 2:]
        pixels = pixels[np.abs(camera.normalise(pixels) - direction).max(axis=1) < 1e-6]
    # The apex goes first: among equals the first wins.
    candidates = np.concatenate([camera.project(T_cn.apply(needle.apex))[None], pixels])
    foremost: Array = candidates[np.argmin(candidates @ backward)]
    return foremost


def apex_is_hidden(needle: Needle, T_cn: Pose, segments: int = SEGMENTS) -> bool:
    """Say whether the needle's own body hides the tip from a camera.

    The solid is convex, so the apex is seen if any face that meets there is turned to the camera.
    """
    vertices, faces = needle.surface(segments)
    centre = T_cn.inverse().t
    distance = np.linalg.norm(vertices - needle.apex, axis=1)
    corner = int(np.argmin(distance))
    a, b, c = (vertices[faces[(faces == corner).any(axis=1)][:, k]] for k in range(3))
    towards = np.einsum("ij,ij->i", np.cross(b - a, c - a), centre - a)
    return not bool((towards > 0).any())


def in_view(needle: Needle, T_cn: Pose, camera: Camera) -> bool:
    """Say whether any part of the needle, at least 1 mm in front, falls on the image.

    Exact for a pinhole; with distortion a needle just outside may be taken to be inside.
    """
    return len(_clipped(needle, T_cn, _view_box(camera, 0.0))) > 0


def footprint(
    needle: Needle, T_cn: Pose, camera: Camera, margin_px: float = 0.0
) -> NDArray[np.bool_]:
    """Mark every pixel that the needle may touch, and all within a margin of those.

    A superset: each pixel whose square overlaps the needle's image is marked, however thin the
    needle is there, and so are the pixels up to `margin_px` from it along u and v (1 px or two
    more, for rounding). The surface's triangles are clipped to the field of view (1 mm in front
    and beyond), projected and filled; the mask is then widened. With distortion, where edges
    become curves, triangles are halved until no edge strays by more than 1/4 px from its chord at
    a quarter, half and three quarters of its length, and twice the worst stray widens the mask.

    Parameters
    ----------
    needle
        The needle.
    T_cn
        Maps the needle's frame to the camera's.
    camera
        The camera.
    margin_px
        How far around the needle to mark, px.

    Returns
    -------
    mask
        (H, W) bool.
    """
    if not 0 <= margin_px < 1e4:
        raise ValueError(f"margin_px has to lie between 0 and 10000, not {margin_px:g}")
    height, width = camera.height, camera.width
    triangles = _clipped(needle, T_cn, _view_box(camera, margin_px + 4))
    if not len(triangles):
        return np.zeros((height, width), dtype=np.bool_)
    stray = 0.0
    if camera.distortion:
        triangles, stray = _straightened(triangles, camera)
    sagitta = needle.radius_mm * (1 - math.cos(math.pi / FOOTPRINT_SEGMENTS))
    inscribed = 2 * sagitta * max(camera.K[0, 0], camera.K[1, 1]) / float(triangles[..., 2].min())
    # 1.5: a touched pixel's centre is within 0.5 px of the triangle, whose outline is drawn
    # within 1 px along either axis. 0.1: the coordinates' rounding to 1/16 px.
    grow = math.ceil(margin_px + 1.5 + 0.1 + inscribed + 2 * stray)
    pad = grow + 1
    canvas = np.zeros((height + 2 * pad, width + 2 * pad), dtype=np.uint8)
    corners = np.rint((camera.project(triangles) + pad) * 16)
    for triangle in corners.astype(np.int32):
        cv2.fillConvexPoly(canvas, triangle, 255, lineType=cv2.LINE_8, shift=4)
    side = 2 * grow + 1
    wide = cv2.dilate(canvas, np.ones((1, side), np.uint8))
    wide = cv2.dilate(wide, np.ones((side, 1), np.uint8))
    mask: NDArray[np.bool_] = wide[pad : pad + height, pad : pad + width] > 0
    return mask


def _require_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} has to be a finite length above 0, not {value:g}")


def _view_box(camera: Camera, margin_px: float) -> tuple[float, float, float, float]:
    """Give x0, x1, y0, y1 of x/z and y/z that hold the image and a margin around it."""
    # The image's edge is half a pixel out; distortion bends it, so it is followed point by point.
    steps = 257 if camera.distortion else 2
    u = np.linspace(-0.5, camera.width - 0.5, steps)
    v = np.linspace(-0.5, camera.height - 0.5, steps)
    border = np.concatenate(
        [np.stack(np.broadcast_arrays(u, edge), axis=1) for edge in (v[0], v[-1])]
        + [np.stack(np.broadcast_arrays(edge, v), axis=1) for edge in (u[0], u[-1])]
    )
    xy = camera.normalise(border)
    low, high = xy.min(axis=0), xy.max(axis=0)
    grow = margin_px / np.diag(camera.K)[:2]
    if camera.distortion:  # pixels need not be equally wide, nor the border's extremes sampled
        grow = 2 * grow + 0.02 * (high - low)
    (x0, y0), (x1, y1) = low - grow, high + grow
    return float(x0), float(x1), float(y0), float(y1)


def _clipped(needle: Needle, T_cn: Pose, box: tuple[float, float, float, float]) -> Array:
    """Give the surface's triangles (n, 3, 3), camera frame, cut to the field of view."""
    vertices, faces = needle.surface(FOOTPRINT_SEGMENTS)
    triangles = T_cn.apply(vertices)[faces]
    x0, x1, y0, y1 = box
    # A point p is inside where normals @ p >= offsets.
    normals = np.array([[0, 0, 1], [1, 0, -x0], [-1, 0, x1], [0, 1, -y0], [0, -1, y1]])
    offsets = np.array([NEAR_MM, 0, 0, 0, 0])
    inside = triangles @ normals.T >= offsets  # (n, corner, plane)
    whole = inside.all(axis=(1, 2))
    crossing = inside.any(axis=1).all(axis=1) & ~whole
    pieces = [triangles[whole]]
    for triangle in triangles[crossing]:
        polygon = triangle
        for normal, offset in zip(normals, offsets, strict=True):
            polygon = _cut(polygon, polygon @ normal - offset)
        if len(polygon) >= 3:
            fan = [polygon[[0, k, k + 1]] for k in range(1, len(polygon) - 1)]
            pieces.append(np.array(fan))
    return np.concatenate(pieces)


def _cut(polygon: Array, height: Array) -> Array:
    """Keep the part of a convex polygon (n, 3) where a linear height (n,) is at least 0."""
    kept: list[Array] = []
    for k in range(len(polygon)):
        a, b, ha, hb = polygon[k - 1], polygon[k], height[k - 1], height[k]
        if (ha >= 0) != (hb >= 0):
            kept.append(a + (b - a) * (ha / (ha - hb)))
        if hb >= 0:
            kept.append(b)
    return np.array(kept).reshape(-1, 3)


def _straightened(triangles: Array, camera: Camera) -> tuple[Array, float]:
    """Halve triangles (n, 3, 3) until their projected edges are nearly straight.

    Returns the triangles and the worst remaining distance of an edge from its chord, px.
    """
    done: list[Array] = []
    worst = 0.0
    for level in range(16):
        stray = _stray(triangles, camera)  # (n, edge)
        bent = (stray.max(axis=1) > 0.25) & (level < 15)
        worst = max(worst, float(stray[~bent].max(initial=0.0)))
        done.append(triangles[~bent])
        if not bent.any():
            break
        split, edge = triangles[bent], stray[bent].argmax(axis=1)
        rows = np.arange(len(split))
        a, b, c = (split[rows, (edge + k) % 3] for k in range(3))
        middle = (a + b) / 2
        triangles = np.concatenate(
            [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        )
    return np.concatenate(done), worst


def _stray(triangles: Array, camera: Camera) -> Array:
    """Give how far the edges (a b, b c, c a) of each triangle bend in the image, (n, 3) px."""
    a, b = triangles, np.roll(triangles, -1, axis=1)
    start, chord = camera.project(a), camera.project(b) - camera.project(a)
    squared = np.maximum((chord**2).sum(axis=-1), 1e-12)
    worst = np.zeros(triangles.shape[:2])
    for share in (0.25, 0.5, 0.75):
        off = camera.project(a + share * (b - a)) - start
        along = np.clip((off * chord).sum(axis=-1) / squared, 0, 1)
        worst = np.maximum(worst, np.linalg.norm(off - along[..., None] * chord, axis=-1))
    return worst
