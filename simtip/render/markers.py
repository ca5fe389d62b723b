"""Render known points, to hold the renderer's geometry against the camera model's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from simtip.camera import Camera
from simtip.geometry import Array, Pose
from simtip.lens import ThinLens
from simtip.render.chunks import batches, means
from simtip.render.engine import dr, mi
from simtip.render.eye import Eye
from simtip.render.progress import Tally
from simtip.render.serial import RowCamera, whole_image
from simtip.render.sobol import points_of
from simtip.render.view import Floats


def render(
    camera: Camera,
    T_wc: Pose,
    points_mm: ArrayLike,
    radius_mm: float,
    samples: int,
    seed: int,
    *,
    lens: ThinLens | None,
    scalar: bool,
) -> Floats:
    """Render bright discs; see `simtip.render.render_discs`."""
    points = np.asarray(points_mm, dtype=np.float64).reshape(-1, 3)
    scene = mi.load_dict(_discs(T_wc, points, radius_mm), parallel=False)
    if scalar:
        rows = RowCamera(camera, T_wc, whole_image(camera))
        direct = mi.load_dict({"type": "direct"})
        return rows.render(scene, direct, samples, seed, Tally(None))[..., 0]
    return _render(scene, Eye(camera, T_wc, lens), camera, samples, seed)


def _discs(T_wc: Pose, points: Array, radius_mm: float) -> dict[str, Any]:
    scene: dict[str, Any] = {"type": "scene"}
    for k, point in enumerate(points):
        to_world = np.eye(4)
        # A disc faces its own +z: turn it about x, towards the camera.
        to_world[:3, :3] = T_wc.R @ np.diag([1.0, -1.0, -1.0]) * radius_mm
        to_world[:3, 3] = point
        scene[f"disc_{k}"] = {
            "type": "disk",
            "to_world": mi.ScalarTransform4f(to_world),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        }
    return scene


def _render(scene: Any, eye: Eye, camera: Camera, samples: int, seed: int) -> Floats:
    image = []
    for part in batches(np.arange(camera.width * camera.height, dtype=np.uint32), samples):
        points, index = points_of(part, samples, seed)
        ray = eye.sample_rays(dr.gather(mi.UInt32, mi.UInt32(part), index), points)
        bright = dr.select(scene.ray_test(ray), mi.Float(1), 0)
        image.append(means([bright], samples))
    return np.concatenate(image).reshape(camera.height, camera.width)
