"""What stands before the cameras: the needle, or a calibration board in its place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from simtip.camera import Camera
from simtip.geometry import Array, Pose

if TYPE_CHECKING:
    from simtip.render.backdrop import Backdrop
    from simtip.render.eye import Eye
    from simtip.render.lighting import Lighting
    from simtip.render.sobol import Points
    from simtip.render.world import World

Mask = NDArray[np.bool_]
Pixels = NDArray[np.uint32]
Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


class Subject(Protocol):
    """What stands before the cameras."""

    def vertices(self) -> Array:
        """Give points (n, 3), world, mm, that it lies within."""

    def footprint(self, T_cw: Pose, camera: Camera, margin_px: float) -> Mask:
        """Mark every pixel (H, W) that it may touch, and all within a margin of those."""

    def shapes(self) -> dict[str, Any]:
        """Describe it to Mitsuba, by name."""

    def bind(self, shapes: dict[str, Any]) -> None:
        """Take hold of its loaded shapes."""

    def light(self, lighting: Lighting) -> None:
        """Work out the light that falls on it, if that is done beforehand."""

    def plain(self, eye: Eye, pixels: Pixels, blur_px: float) -> Mask:
        """Say of which pixels (n,), flat indices, it is known that they show something smooth.

        Nothing farther than `blur_px` from a pixel's centre may count.
        """

    def met(self, si: Vec) -> Vec:
        """Say which rays meet it."""

    def slipped(self, hit: Vec, ray: Vec) -> Vec:
        """Say which rays slipped in between two of its triangles."""

    def radiance(
        self, world: World, backdrop: Backdrop, ray: Vec, si: Vec, points: Points, active: Vec
    ) -> list[Vec]:
        """Give what rays that met it bring, per light group (ambient last)."""
