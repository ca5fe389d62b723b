"""Mitsuba's own `path` integrator on a scene of simtip's: what the renderer is measured against.

All lamps and the room are lit at once, at the scene's powers, so that one image comes out where
simtip makes one per lamp. All else is as good as stock Mitsuba gives it: any of its samplers,
a box filter, the metal and the mesh of simtip.

Mitsuba's perspective camera has square pixels: fy is taken to be fx, which shifts the outermost
rows by 0.5 % and changes neither cost nor noise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip import Camera, Pose, SceneSpec
from simtip.render.engine import mi
from simtip.render.lamps import lamps_of
from simtip.render.stock import stock_scene

SAMPLERS = ("multijitter", "independent", "stratified", "orthogonal", "ldsampler")
"""All that Mitsuba has."""


class StockPath:
    """A loaded scene, to be looked at by any camera; build and use it on an active back end.

    Parameters
    ----------
    spec
        The scene.
    room_weight
        How often the room is chosen as the emitter to sample, where each lamp has weight 1; 1 is
        Mitsuba's default. The room gives little of the light and samples spent on it are noise.
    sampler
        One of `SAMPLERS`.
    """

    def __init__(
        self, spec: SceneSpec, room_weight: float = 1.0, sampler: str = SAMPLERS[0]
    ) -> None:
        self._sampler = sampler
        scene = stock_scene(spec, lit="ambient")
        scene["ambient"] = {
            "type": "constant",
            "radiance": _rgb(spec.ambient.radiance_w_m2_sr),
            "sampling_weight": room_weight,
        }
        for lamp, bodies in zip(spec.lamps, lamps_of(spec.lamps), strict=True):
            for name in bodies.shape_ids():
                scene[name]["emitter"] = {"type": "area", "radiance": _rgb(lamp.radiance())}
        self._scene = mi.load_dict(scene, parallel=False)
        self._integrator = mi.load_dict({"type": "path"})

    def render(
        self, camera: Camera, T_wc: Pose, samples: int, seed: int = 0
    ) -> NDArray[np.float32]:
        """Render one view: (H, W) radiance, W m^-2 sr^-1, mean of the channels."""
        image = mi.render(
            self._scene,
            sensor=_sensor(camera, T_wc, self._sampler),
            integrator=self._integrator,
            spp=samples,
            seed=seed,
        )
        gray: NDArray[np.float32] = np.array(image)[..., :3].mean(axis=-1)
        return gray


def _rgb(value: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(v) for v in value]}


def _sensor(camera: Camera, T_wc: Pose, sampler: str) -> Any:
    K = camera.K
    to_world = T_wc.matrix()
    to_world[:3, :3] = T_wc.R @ np.diag([-1.0, -1.0, 1.0])  # Mitsuba: x to the left, y up
    return mi.load_dict(
        {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f(to_world.tolist()),
            "fov": float(np.degrees(2 * np.arctan(camera.width / 2 / K[0, 0]))),
            "fov_axis": "x",
            "near_clip": 1.0,
            "far_clip": 1e5,
            # A film spans [0, width); pixel centres lie half a pixel in.
            "principal_point_offset_x": float(0.5 - (K[0, 2] + 0.5) / camera.width),
            "principal_point_offset_y": float(0.5 - (K[1, 2] + 0.5) / camera.height),
            "film": {
                "type": "hdrfilm",
                "width": camera.width,
                "height": camera.height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": sampler, "sample_count": 16},
        }
    )
