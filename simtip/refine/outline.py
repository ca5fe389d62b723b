"""Where a known needle is seen: its outline and facets in one picture.

The outline of a convex solid is the hull of its points as the camera sees them. It is built before
distortion, where it is convex, and then distorted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from simtip.camera import Camera
from simtip.detect.subpixel.frame import Frame
from simtip.geometry import Array, Pose, unit
from simtip.refine.solid import Solid

CHORDS = 64
"""To the outline's length: how finely distortion bends it."""


@dataclass(frozen=True, eq=False)
class Eye:
    """A camera of the rig and how its picture is turned.

    Attributes
    ----------
    camera
        Its intrinsics.
    T_cw
        From the rig's frame to the camera's.
    frame
        Turns the picture so that the needle points down.
    """

    camera: Camera
    T_cw: Pose
    frame: Frame

    def see(self, points: Array) -> Array:
        """Project points (..., 3) of the camera's frame to u, v of the turned picture."""
        return self.frame.points(self.camera.project(points))


@dataclass(frozen=True, eq=False)
class Outline:
    """A needle's outline in the turned picture.

    Coordinates there: z along the axis from the tip towards the hub, x across it, px.

    Attributes
    ----------
    origin
        (2,) u, v of the axis at the foremost point's z.
    hub
        (2,) unit vector along z.
    corners
        (m, 2) u, v of the outline, in order.
    left, right
        (n, 2) z and x of both sides from the foremost point on, z increasing.
    shaft
        Likewise (left, right) of the shaft as if it went on beyond the tip.
    facets
        For every facet of the solid its outline (k, 2) u, v; None if it looks away.
    depth_px, bulge_px
        z of the axis where the shaft begins, and how much further in the middle of the needle's
        near side.
    """

    origin: Array
    hub: Array
    corners: Array
    left: Array
    right: Array
    shaft: tuple[Array, Array]
    facets: tuple[Array | None, ...]
    depth_px: float
    bulge_px: float

    def place(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Give x and z of points (...)."""
        off_u, off_v = u - self.origin[0], v - self.origin[1]
        x = off_v * self.hub[0] - off_u * self.hub[1]
        return np.asarray(x), np.asarray(off_u * self.hub[0] + off_v * self.hub[1])

    def sides(self, z: Array) -> tuple[Array, Array]:
        """Give x of the left and the right side at z (...); the foremost point's in front of it."""
        return at_z(self.left, z), at_z(self.right, z)


def at_z(side: Array, z: Array) -> Array:
    """Give x of a side (n, 2) z, x at z (...)."""
    return np.interp(z.reshape(-1), side[:, 0], side[:, 1]).reshape(z.shape)


def outline(solid: Solid, T_wn: Pose, eye: Eye, end_mm: float) -> Outline:
    """Project a needle.

    Parameters
    ----------
    solid
        Its shape.
    T_wn
        Its place in the rig's frame.
    eye
        Who sees it.
    end_mm
        z of the needle at which it is cut off, out of sight; above its depth.
    """
    T_cn = eye.T_cw @ T_wn
    axis = T_cn.apply(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, end_mm]]))
    ends = eye.see(axis)
    origin, hub = ends[0], unit(ends[1] - ends[0])
    kept = solid.front[solid.front[:, 2] <= end_mm]
    ring = np.column_stack([solid.ring, np.full(len(solid.ring), end_mm)])
    ahead = np.column_stack([solid.ring, np.full(len(solid.ring), -2 * solid.radius_mm)])
    cylinder = np.concatenate([ahead, ring])
    corners, shaft = (
        eye.see(_ahead(_hull(T_cn.apply(points), eye)))
        for points in (np.concatenate([kept, ring]), cylinder)
    )
    sides = [_sides(np.stack(_place(uv, origin, hub), 1)) for uv in (corners, shaft)]
    facets = tuple(
        _facet(T_cn.apply(facet.corners), T_cn.rotate(facet.normal), eye) for facet in solid.facets
    )
    centre = np.array([0.0, 0.0, solid.depth_mm])
    toward = T_cn.inverse().apply(np.zeros(3)) * [1, 1, 0]
    near = centre + solid.radius_mm * unit(toward) if toward.any() else centre
    depths = _place(eye.see(T_cn.apply(np.stack([centre, near]))), origin, hub)[1]
    return Outline(
        origin,
        hub,
        corners,
        *sides[0],
        sides[1],
        facets,
        float(depths[0]),
        float(depths[1] - depths[0]),
    )


def _ahead(xy: Array) -> Array:
    return np.column_stack([xy, np.ones(len(xy))])


def _place(uv: Array, origin: Array, hub: Array) -> tuple[Array, Array]:
    off = uv - origin
    return off[:, 1] * hub[0] - off[:, 0] * hub[1], off @ hub


def _hull(points: Array, eye: Eye) -> Array:
    """Give the hull (n, 2), in order, of points (m, 3) of the camera's frame, at depth 1.

    If the camera distorts, its long sides are divided.
    """
    xy = points[:, :2] / points[:, 2:]
    corners = xy[scipy.spatial.ConvexHull(xy).vertices]
    if not eye.camera.distortion:
        return corners
    after = np.roll(corners, -1, axis=0)
    length = np.linalg.norm(after - corners, axis=1)
    parts = np.maximum(1, np.ceil(length / (length.max() / CHORDS))).astype(np.intp)
    start = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(parts.sum()) - start) / np.repeat(parts, parts)
    return np.asarray(
        np.repeat(corners, parts, axis=0)
        + share[:, None] * np.repeat(after - corners, parts, axis=0)
    )


def _sides(xz: Array) -> tuple[Array, Array]:
    """Split an outline (n, 2) x, z at its ends into left and right: (k, 2) z, x, z increasing."""
    xz = np.roll(xz, -int(np.argmin(xz[:, 1])), axis=0)
    k = int(np.argmax(xz[:, 1]))
    one, other = xz[: k + 1], np.concatenate([xz[k:], xz[:1]])[::-1]
    sides = [np.column_stack([np.maximum.accumulate(s[:, 1]), s[:, 0]]) for s in (one, other)]
    middle = [
        float(np.interp(0.5 * (xz[0, 1] + xz[k, 1]), side[:, 0], side[:, 1])) for side in sides
    ]
    return (sides[0], sides[1]) if middle[0] < middle[1] else (sides[1], sides[0])


def _facet(corners: Array, normal: Array, eye: Eye) -> Array | None:
    if normal @ corners[0] >= 0:
        return None
    xy = corners[:, :2] / corners[:, 2:]
    return eye.see(_ahead(xy[scipy.spatial.ConvexHull(xy, qhull_options="QJ").vertices]))
