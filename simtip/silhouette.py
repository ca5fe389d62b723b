"""What a camera makes of a needle's tip: the axis in the image, the foremost point, what is hidden.

Only geometry: nothing is rendered.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.geometry import Array, Pose, unit
from simtip.needle import Needle
from simtip.needle.inside import hides

NEAR_MM = 1.0
"""Nothing closer to a camera's centre plane than this is taken to be seen."""

COARSE_SEGMENTS = 128
"""Sides of the polygon with which a needle's own shadow on its tip is worked out."""


def projected_axis(needle: Needle, T_cn: Pose, camera: Camera) -> Array:
    """Give the image direction from the tip towards the hub, at the tip: (2,), unit length.

    It is the derivative of the projection at the apex along the axis, so it holds with distortion;
    of a bent needle the axis is the tangent at the tip.

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
    jacobian = projection_jacobian(camera, apex)
    along = jacobian @ T_cn.R[:, 2]
    scale = max(camera.K[0, 0], camera.K[1, 1]) / apex[2]
    if not np.linalg.norm(along) > 1e-9 * scale:
        raise ValueError(
            "the needle points straight at the camera: its axis has no direction there"
        )
    return unit(along)


def projection_jacobian(camera: Camera, point: Array) -> Array:
    """Give the derivative (2, 3) of the projection by the point (3,), camera frame, px per mm."""
    distortion = np.asarray(camera.distortion) if camera.distortion else np.zeros(4)
    _, jacobian = cv2.projectPoints(
        point.reshape(1, 1, 3), np.zeros(3), np.zeros(3), camera.K, distortion
    )
    # The derivative by the translation (columns 3 to 5) is the derivative by the point.
    by_point: Array = np.asarray(jacobian, dtype=np.float64)[:, 3:6]
    return by_point


def silhouette_tip(
    needle: Needle, T_cn: Pose, camera: Camera, segments: int | None = None
) -> Array:
    """Give the foremost point of the needle's image, (2,) px, occluded or not.

    Foremost is furthest against `projected_axis`, of the whole needle: a needle bent far round may
    have it elsewhere than at its tip. A vertex is always foremost in a pinhole's image of a
    polyhedron, so the result is exact for the polygonal needle of `segments`; on the round needle
    the point lies as far forward to within `Needle.surface`'s silhouette error, and, where the
    outline is a round rim there, up to half a segment (``pi R / segments``) to the side. On the
    rounding of a tip it is exact: there the point is where a ball touches.

    Raises
    ------
    ValueError
        As `projected_axis`.
    """
    backward = projected_axis(needle, T_cn, camera)
    vertices, _ = needle.surface(segments)
    points = T_cn.apply(vertices)
    points = points[points[:, 2] > NEAR_MM]
    pixels = camera.project(points)
    if camera.distortion and len(
        pixels
    ):  # beyond the field of view the model may fold back into the image
        direction = points[:, :2] / points[:, 2:]
        seen = np.abs(camera.normalise(pixels) - direction).max(axis=1) < 1e-6
        points, pixels = points[seen], pixels[seen]
    # The apex goes first: among equals the first wins.
    apex = T_cn.apply(needle.apex)[None]
    candidates = np.concatenate([camera.project(apex), pixels])
    best = int(np.argmin(candidates @ backward))
    if needle.tip.tip_radius_mm > 0:
        start = np.concatenate([apex, points])[best]
        return _on_the_balls(needle, T_cn, camera, start, backward, segments)
    foremost: Array = candidates[best]
    return foremost


def _on_the_balls(
    needle: Needle, T_cn: Pose, camera: Camera, start: Array, backward: Array, segments: int | None
) -> Array:
    """Move from a vertex (3,) to the foremost point of the balls that make up the tip.

    Where the image's gradient at the point says, which ball and which point of it are foremost:
    for a pinhole this is Dinkelbach's method for a ratio of linear functions.
    """
    r = needle.tip.tip_radius_mm
    centres = T_cn.apply(needle.core(segments))
    centres = centres[np.linalg.norm(centres - start, axis=1) < 2 * r]
    pixel: Array = camera.project(start)
    for _ in range(20 if len(centres) else 0):
        gradient = backward @ projection_jacobian(camera, start)
        start = centres[np.argmin(centres @ gradient)] - r * unit(gradient)
        moved = camera.project(start)
        if not moved @ backward < pixel @ backward:
            break
        pixel = moved
    return pixel


def apex_is_hidden(needle: Needle, T_cn: Pose) -> bool:
    """Say whether the needle's own body hides the tip from a camera.

    Every kind of tip is convex at its apex, so the apex is seen if any face that meets there is
    turned to the camera and no other part of the needle, a crown's far side or the bent shaft,
    lies in between. Of a rounded tip the faces are those of the ball at the tip: it is seen if any
    part of that ball is, even where the one foremost point is just beyond the ball's horizon, so
    that a small radius makes no other statement than a sharp tip. The shaft is taken with 128
    sides.
    """
    vertices, faces = needle.surface(COARSE_SEGMENTS)
    return hides(vertices, faces, _tip_vertices(needle, vertices), T_cn.inverse().t)


def _tip_vertices(needle: Needle, vertices: Array) -> NDArray[np.int64]:
    """Give the vertices of the ball at the tip, the nearest to the apex first."""
    r = needle.tip.tip_radius_mm
    off = np.linalg.norm(vertices - needle.apex, axis=1)
    near = np.flatnonzero(off <= 3 * r)
    if r == 0:
        return np.array([np.argmin(off)])
    near = near[np.argsort(off[near], kind="stable")]
    straight = vertices[near] if needle.bend is None else needle.bend.undo(vertices[near])
    from_centre = np.linalg.norm(straight - needle.apex - [0, 0, r], axis=1)
    on_ball: NDArray[np.int64] = near[from_centre <= r * (1 + 1e-6)]
    return on_ball
