"""A camera in the renderer's own numbers, opaque, so that all cameras share their kernels."""

from __future__ import annotations

from typing import Any

from simtip.camera import Camera
from simtip.geometry import Pose
from simtip.lens import ThinLens
from simtip.render.distortion import Distortion
from simtip.render.engine import dr, mi
from simtip.render.sobol import Points


class Eye:
    """Makes rays for points of pixels and, with a lens, points of its aperture.

    Parameters
    ----------
    camera
        Intrinsics and distortion.
    T_wc
        Its pose in the world.
    lens
        None for a pinhole.
    """

    def __init__(self, camera: Camera, T_wc: Pose, lens: ThinLens | None = None) -> None:
        K = camera.K
        self.columns = camera.width
        self._width = dr.opaque(mi.UInt32, camera.width)
        self._fx, self._fy, self._cx, self._cy = (
            dr.opaque(mi.Float, float(v)) for v in (K[0, 0], K[1, 1], K[0, 2], K[1, 2])
        )
        self.axes = [
            mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in column]) for column in T_wc.R.T
        ]
        self.origin = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in T_wc.t])
        self._distortion = Distortion(camera) if camera.distortion else None
        self._aperture: tuple[Any, Any] | None = None
        if lens is not None:
            radius, focus = lens.aperture_mm / 2, lens.focus_mm
            self._aperture = dr.opaque(mi.Float, radius), dr.opaque(mi.Float, focus)

    def chief_rays(self, pixel: Any, offset: Any) -> Any:
        """Rays through the middle of the aperture.

        Parameters
        ----------
        pixel
            Index v * width + u.
        offset
            In [0, 1)^2 across the pixel's square; (0.5, 0.5) is its centre, which is where
            OpenCV's integer coordinates lie.
        """
        return mi.Ray3f(self.origin, dr.normalize(self._towards(pixel, offset)))

    def sample_rays(self, pixel: Any, points: Points) -> Any:
        """Rays through a random point of each pixel and of the aperture."""
        towards = self._towards(pixel, points.pixel())
        if self._aperture is None:
            return mi.Ray3f(self.origin, dr.normalize(towards))
        radius, focus = self._aperture
        on_lens = radius * mi.warp.square_to_uniform_disk_concentric(points.aperture())
        # Vectors throughout: a Point minus a Vector would be translated by later transforms.
        shift = on_lens.x * self.axes[0] + on_lens.y * self.axes[1]
        return mi.Ray3f(self.origin + shift, dr.normalize(focus * towards - shift))

    def _towards(self, pixel: Any, offset: Any) -> Any:
        """Give the world direction with camera z = 1."""
        v = pixel // self._width
        u = pixel - v * self._width
        x = ((mi.Float(u) - self._cx) + (offset.x - 0.5)) / self._fx
        y = ((mi.Float(v) - self._cy) + (offset.y - 0.5)) / self._fy
        if self._distortion is not None:
            x, y = self._distortion.undo(x, y)
        return x * self.axes[0] + y * self.axes[1] + self.axes[2]
