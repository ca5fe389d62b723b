"""One camera's picture of the scene, as light per lamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.spec import SceneSpec

Floats = NDArray[np.float32]
Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1."""


@dataclass(frozen=True, eq=False)
class View:
    """What one camera sees; arrays are row-major, first row at the top.

    Attributes
    ----------
    lamps
        Names of the lamps, in the scene's order, and "ambient" last.
    response
        (lamps, H, W, 3) float32, radiance per unit radiance of each lamp; channels r g b.
    coverage
        (H, W) float32, the part of each pixel that the needle covers, 0 to 1.
    depth_mm
        (H, W) float32, camera z of the nearest surface at the pixel's centre; inf where none.
    backend
        What rendered it.
    """

    lamps: tuple[str, ...]
    response: Floats
    coverage: Floats
    depth_mm: Floats
    backend: str

    def radiance(self, spec: SceneSpec) -> Floats:
        """Mix the lamps at the scene's powers: (H, W, 3) float32, W m^-2 sr^-1 per channel."""
        total = np.zeros(self.response.shape[1:], np.float32)
        power = {lamp.name: lamp.radiance() for lamp in spec.lamps}
        power["ambient"] = np.array(spec.ambient.radiance_w_m2_sr)
        for name, response in zip(self.lamps, self.response, strict=True):
            if power[name].any():
                total += response * power[name].astype(np.float32)
        return total
