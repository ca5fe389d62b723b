"""Light from a point: a matt sphere too small for its size to matter."""

from __future__ import annotations

from typing import Any

import numpy as np
from typing_extensions import override

from simtip.geometry import Array
from simtip.render.emitters.sample import Emitter, LampSample
from simtip.render.engine import dr, mi

Vec = Any  # a Dr.Jit vector of the active variant: these types exist only once it is set


class Bulb(Emitter):
    """A point that shines equally to all sides; rays cannot hit it.

    Its intensity is that of a matt sphere, radiance times the area pi d^2 / 4 that it shows.
    """

    def __init__(self, centre: Array, diameter_mm: float) -> None:
        self._centre = mi.Point3f([dr.opaque(mi.Float, float(v)) for v in centre])
        self._shown_mm2 = dr.opaque(mi.Float, float(np.pi * diameter_mm**2 / 4))

    def shape(self) -> None:
        """Describe nothing: rays pass it by."""

    @override
    def sample(self, x: Vec, xi: Vec) -> LampSample:
        """Give the point, whatever the numbers."""
        to_point = self._centre - x
        d2 = dr.squared_norm(to_point)
        weight = self._shown_mm2 / d2
        return LampSample(self._centre, to_point * dr.rsqrt(d2), weight, mi.Float(dr.inf))

    @override
    def pdf(self, x: Vec, point: Vec, normal: Vec) -> Vec:
        """Give 0: no ray finds it by chance."""
        return mi.Float(0)
