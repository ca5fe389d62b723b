"""Lens distortion undone along the ray: no rendered image is ever warped."""

from __future__ import annotations

from typing import Any

from simtip.camera import Camera
from simtip.render.engine import dr, mi
from simtip.undistort import TOLERANCE_PX, Terms, plan, terms, undo


class Distortion:
    """OpenCV's radial (also rational) and tangential distortion, in the renderer's own numbers.

    Parameters
    ----------
    camera
        Whose pixels are to be undone; its distortion is not empty.

    Raises
    ------
    ValueError
        More than eight coefficients, or a model that is not undone within `TOLERANCE_PX` all over
        the image; scenes with such a lens do not load.
    """

    def __init__(self, camera: Camera) -> None:
        chosen = plan(camera)
        if chosen.error_px > TOLERANCE_PX:
            raise ValueError(f"the distortion {camera.distortion} cannot be undone")
        # Opaque numbers, so that cameras share their kernels.
        self._terms = Terms(
            *(dr.opaque(mi.Float, v) for v in vars(terms(camera.distortion)).values())
        )
        self._start = tuple(dr.opaque(mi.Float, c) for c in chosen.start)
        self._steps = chosen.steps

    def undo(self, x_d: Any, y_d: Any) -> tuple[Any, Any]:
        """Find the (x, y) = (X/Z, Y/Z) that is distorted to (x_d, y_d)."""
        return undo(x_d, y_d, self._terms, self._start, self._steps)
