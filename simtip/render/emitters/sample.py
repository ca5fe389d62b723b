"""What sampling a lamp gives, whatever its shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

Vec = Any  # a Dr.Jit vector of the active variant: these types exist only once it is set


@dataclass(frozen=True)
class LampSample:
    """One point on a lamp as seen from a point x."""

    point: Vec
    direction: Vec
    """From x to the point, unit."""
    weight: Vec
    """Factor of radiance in the integral over directions: 1 / pdf, 0 where nothing is seen."""
    pdf: Vec
    """Density per solid angle at x; infinite for what is too small to be hit by chance."""


class Emitter(Protocol):
    """One shining body of a lamp."""

    def shape(self) -> dict[str, Any] | None:
        """Describe it to Mitsuba; None if rays cannot hit it."""

    def sample(self, x: Vec, xi: Vec) -> LampSample:
        """Sample a point with two uniform numbers ``xi``."""

    def pdf(self, x: Vec, point: Vec, normal: Vec) -> Vec:
        """Density per solid angle at x with which `sample` finds a point of the lamp."""
