"""What lies behind pixel centres: depth and masks by single rays, without any light."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.camera import Camera, StereoRig
from simtip.geometry import Array, Pose
from simtip.render.backdrop import Plane
from simtip.render.chunks import aligned, batches
from simtip.render.engine import dr, mi
from simtip.render.eye import Eye
from simtip.render.needle_subject import NeedleSubject
from simtip.render.pair import solid_clutter
from simtip.render.subject import Mask
from simtip.render.view import Floats
from simtip.render.wavefront import first_hits
from simtip.render.world import World, load_world
from simtip.spec import SceneSpec

NEAR = 1e-5
"""A surface counts as before a point if it is nearer by this share of the distance."""


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What one camera's pixel centres see, as a pinhole: nothing is blurred.

    Attributes
    ----------
    depth_mm
        (H, W) camera z of the nearest surface; inf where there is none.
    needle
        (H, W) where that is the needle's.
    silhouette
        (H, W), or larger all around, where the needle is, whatever stands before it.
    obstructed
        (n,) before which points something else than the needle stands.
    """

    depth_mm: Floats
    needle: Mask
    silhouette: Mask
    obstructed: Mask


def trace(
    spec: SceneSpec, rig: StereoRig, points_mm: ArrayLike, beyond: int
) -> tuple[Surfaces, Surfaces]:
    """Trace both views; see `simtip.render.trace_surfaces`."""
    # The walls are no shapes, and their light is not wanted.
    bare = spec.model_copy(update={"room": None})
    subject = NeedleSubject(bare)
    alone = mi.load_dict({"type": "scene", **subject.shapes()}, parallel=False)
    world = load_world(bare, spec.seed, subject, solid_clutter(spec, spec.seed))
    points = np.asarray(points_mm, dtype=np.float64).reshape(-1, 3)
    views = (rig.left, Pose.identity()), (rig.right, rig.T_lr)
    left, right = (_seen(world, alone, camera, T_wc, points, beyond) for camera, T_wc in views)
    return left, right


def _seen(
    world: World, alone: Any, camera: Camera, T_wc: Pose, points: Array, beyond: int
) -> Surfaces:
    hits = first_hits(world, Plane(world.board), Eye(camera, T_wc), camera.width * camera.height)
    shape = camera.height, camera.width
    return Surfaces(
        hits.depth_mm.reshape(shape),
        hits.subject.reshape(shape),
        _silhouette(world, alone, _widened(camera, beyond), T_wc),
        _obstructed(world, T_wc, points),
    )


def _widened(camera: Camera, beyond: int) -> Camera:
    """Give the camera with an image that goes on beyond its borders."""
    if not beyond:
        return camera
    if camera.distortion:
        raise ValueError("beyond the image its distortion means nothing")
    wide, high = camera.size
    K = camera.K + np.array([[0, 0, beyond * wide], [0, 0, beyond * high], [0, 0, 0]])
    grown = 2 * beyond + 1
    return replace(camera, K=K, width=grown * wide, height=grown * high)


def _silhouette(world: World, alone: Any, camera: Camera, T_wc: Pose) -> Mask:
    """Mark the pixels (H, W) whose centres see the needle where nothing else is there."""
    mask = world.subject.footprint(T_wc.inverse(), camera, 0.0)
    eye = Eye(camera, T_wc)
    pixels = np.flatnonzero(mask).astype(np.uint32)
    found: list[NDArray[np.bool_]] = [np.zeros(0, np.bool_)]
    for part in batches(pixels, 1):
        ray = eye.chief_rays(mi.UInt32(aligned(part)), mi.Point2f(0.5, 0.5))
        found.append(alone.ray_intersect_preliminary(ray).is_valid().numpy())
    mask[mask] = np.concatenate(found)
    return mask


def _obstructed(world: World, T_wc: Pose, points: Array) -> Mask:
    """Say before which points (n, 3) something else than the subject stands."""
    if not len(points):
        return np.zeros(0, np.bool_)
    away = points - T_wc.t
    distance = np.linalg.norm(away, axis=1)
    directions = (away / distance[:, None]).astype(np.float32)
    ray = mi.Ray3f(
        mi.Point3f(*map(float, T_wc.t)),
        mi.Vector3f(*(mi.Float(np.ascontiguousarray(column)) for column in directions.T)),
    )
    hit = world.scene.ray_intersect(ray)
    near = hit.t < mi.Float((distance * (1 - NEAR)).astype(np.float32))
    other = near & ~world.subject.met(hit)
    dr.eval(other)
    return np.asarray(other.numpy(), np.bool_)
