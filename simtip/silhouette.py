"""What a camera makes of a needle's tip: the axis in the image, the foremost point, what is hidden.

Only geometry: nothing is rendered.
"""

from __future__ import annotations

import cv2
import numpy as np

from simtip.camera import Camera
from simtip.geometry import Array, Pose, unit
from simtip.needle import SEGMENTS, Needle

NEAR_MM = 1.0
"""Nothing closer to a camera's centre plane than this is taken to be seen."""


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
