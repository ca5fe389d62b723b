"""One image of a BOP scene: what is stored of it, and what is said of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.sensor import Image

if TYPE_CHECKING:
    from simtip.render.surfaces import Surfaces

Mask = NDArray[np.bool_]

BEYOND = 1
"""A silhouette is counted on a canvas of three by three images, as BOP's toolkit does."""

FINEST_MM = 0.01
"""Depth of one count, where 16 bit reach far enough: up to 655.35 mm."""

MOST = 65535

NOWHERE = [-1, -1, -1, -1]
"""BOP's box of what is not seen."""


@dataclass(frozen=True, eq=False)
class BopView:
    """One image with its annotation.

    Attributes
    ----------
    image
        (H, W, 3), of a pinhole.
    camera
        It; without distortion.
    T_cw, T_cm
        From world and model to camera, mm.
    surfaces
        What the camera sees, its silhouette on three by three images.
    known
        (H, W) where there is an image.
    """

    image: NDArray[np.uint8] | Image
    camera: Camera
    T_cw: Pose
    T_cm: Pose
    surfaces: Surfaces
    known: Mask

    @property
    def mask(self) -> Mask:
        """The needle's silhouette in the image, whatever stands before it."""
        height, width = self.camera.height, self.camera.width
        inner: Mask = self.surfaces.silhouette[height : 2 * height, width : 2 * width]
        return inner

    @property
    def mask_visib(self) -> Mask:
        """What is seen of it."""
        return self.surfaces.needle & self.known

    def depth(self) -> tuple[NDArray[np.uint16], float]:
        """Give depth in counts, 0 where there is none, and what a count is, mm."""
        there = np.isfinite(self.surfaces.depth_mm) & self.known
        depth = np.where(there, self.surfaces.depth_mm, 0).astype(np.float64)
        scale = depth_scale(float(depth.max(initial=0.0)))
        return np.rint(depth / scale).astype(np.uint16), scale

    def camera_entry(self, scale: float) -> dict[str, Any]:
        """Give its entry of ``scene_camera.json``."""
        return {
            "cam_K": self.camera.K.ravel().tolist(),
            "depth_scale": scale,
            "cam_R_w2c": self.T_cw.R.ravel().tolist(),
            "cam_t_w2c": self.T_cw.t.tolist(),
        }

    def pose_entry(self, model: int) -> dict[str, Any]:
        """Give the needle's entry of ``scene_gt.json``."""
        return {
            "obj_id": model,
            "cam_R_m2c": self.T_cm.R.ravel().tolist(),
            "cam_t_m2c": self.T_cm.t.tolist(),
        }

    def info_entry(self, depth: NDArray[np.uint16]) -> dict[str, Any]:
        """Give the needle's entry of ``scene_gt_info.json``."""
        visible = self.mask_visib
        everywhere, seen = int(self.surfaces.silhouette.sum()), int(visible.sum())
        corner = BEYOND * self.camera.width, BEYOND * self.camera.height
        return {
            "bbox_obj": box(self.surfaces.silhouette, corner) if seen else NOWHERE,
            "bbox_visib": box(visible) if seen else NOWHERE,
            "px_count_all": everywhere,
            "px_count_valid": int((depth[self.mask] > 0).sum()),
            "px_count_visib": seen,
            "visib_fract": seen / everywhere if everywhere else 0.0,
        }


def depth_scale(largest_mm: float) -> float:
    """Give the depth of a count, mm: 0.01, or the next of 0.02, 0.05, 0.1 .. that suffices."""
    scale, steps = FINEST_MM, iter(range(100))
    while largest_mm > MOST * scale:
        power, step = divmod(next(steps) + 1, 3)
        scale = float(f"{(1, 2, 5)[step]}e{power - 2}")
    return scale


def box(mask: Mask, origin: tuple[int, int] = (0, 0)) -> list[int]:
    """Give BOP's box of a mask: least x and y, and from there to the largest, of pixel indices."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    x, y = int(columns[0]), int(rows[0])
    return [x - origin[0], y - origin[1], int(columns[-1]) - x, int(rows[-1]) - y]
