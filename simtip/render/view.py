"""One camera's picture of the scene, as light per lamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simtip.mix import mix, weights
from simtip.render.noise import Noise
from simtip.spec import SceneSpec

Floats = NDArray[np.float32]
Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1."""

Tolerance = Callable[[Floats, Floats | None], Floats]
"""From mixed radiance (n, 3), and the background's (3,) if any is in view, to the standard
deviation (n,) that Monte-Carlo noise may have in the mean over the channels."""


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
    clutter
        (H, W) float32, the part of each pixel that clutter covers, printed or solid.
    depth_mm
        (H, W) float32, camera z of the nearest surface at the pixel's centre; inf where none.
    noise
        Monte-Carlo error of every pixel.
    backend
        What rendered it.
    """

    lamps: tuple[str, ...]
    response: Floats
    coverage: Floats
    clutter: Floats
    depth_mm: Floats
    noise: Noise
    backend: str

    def radiance(self, spec: SceneSpec) -> Floats:
        """Mix the lamps as the scene has them: (H, W, 3) float32, W m^-2 sr^-1 per channel."""
        power = weights(spec, self.response.shape[1])
        return mix(self.response, [power[name] for name in self.lamps])
