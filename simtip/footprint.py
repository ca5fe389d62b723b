"""Which pixels a needle may touch, so that nothing need be rendered elsewhere."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.geometry import Array, Pose
from simtip.needle import Faces, Needle
from simtip.silhouette import NEAR_MM

SEGMENTS = 128
"""Sides of the polygon that stands for the circle here; what it cuts off widens the mask."""

SAGITTA_MM = 5e-3
"""How far a bend or a rounding may stray from its chords here, which widens the mask, too."""


def in_view(needle: Needle, T_cn: Pose, camera: Camera) -> bool:
    """Say whether any part of the needle, at least 1 mm in front, falls on the image.

    Exact for a pinhole and the needle's mesh; with distortion a needle just outside may be taken
    to be inside.
    """
    surface = needle.surface(SEGMENTS)
    return len(_clipped(surface, T_cn, _view_box(camera, 0.0))) > 0


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
    surface = needle.surface(SEGMENTS, SAGITTA_MM)
    triangles = _clipped(surface, T_cn, _view_box(camera, margin_px + 4))
    if not len(triangles):
        return np.zeros((height, width), dtype=np.bool_)
    stray = 0.0
    if camera.distortion:
        triangles, stray = _straightened(triangles, camera)
    sagitta = needle.radius_mm * (1 - math.cos(math.pi / SEGMENTS))
    if needle.bend_radius_mm is not None or needle.tip.tip_radius_mm > 0:
        sagitta += SAGITTA_MM
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


def _clipped(
    surface: tuple[Array, Faces], T_cn: Pose, box: tuple[float, float, float, float]
) -> Array:
    """Give a surface's triangles (n, 3, 3), camera frame, cut to the field of view."""
    vertices, faces = surface
    triangles = T_cn.apply(vertices)[faces]
    x0, x1, y0, y1 = box
    # A point p is inside where normals @ p >= offsets.
    normals = np.array([[0, 0, 1], [1, 0, -x0], [-1, 0, x1], [0, 1, -y0], [0, -1, y1]])
    offsets = np.array([NEAR_MM, 0, 0, 0, 0])
    for normal, offset in zip(normals, offsets, strict=True):
        triangles = _cut(triangles, triangles @ normal - offset)
    return triangles


def _cut(triangles: Array, height: Array) -> Array:
    """Keep the part of triangles (n, 3, 3) where a linear height (n, 3) is at least 0."""
    inside = height >= 0
    count = inside.sum(axis=1)
    pieces = [triangles[count == 3]]
    for corners in (1, 2):
        crossing = count == corners
        if not crossing.any():
            continue
        part, h = triangles[crossing], height[crossing]
        # Turn each so that the corner alone on its side comes first.
        first = (inside[crossing] == (corners == 1)).argmax(axis=1)
        order = (first[:, None] + np.arange(3)) % 3
        part, h = (
            np.take_along_axis(part, order[..., None], axis=1),
            np.take_along_axis(h, order, 1),
        )
        a, b, c = part[:, 0], part[:, 1], part[:, 2]
        ab = a + (b - a) * (h[:, 0] / (h[:, 0] - h[:, 1]))[:, None]
        ac = a + (c - a) * (h[:, 0] / (h[:, 0] - h[:, 2]))[:, None]
        if corners == 1:
            pieces.append(np.stack([a, ab, ac], axis=1))
        else:
            pieces += [np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)]
    return np.concatenate(pieces)


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
