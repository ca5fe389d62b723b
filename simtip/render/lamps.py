"""A lamp in the renderer: a light group of one or more shining bodies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from simtip.render.emitters import Emitter, emitters_of
from simtip.render.engine import dr, mi
from simtip.spec import LampSpec


@dataclass(eq=False)
class Lamp:
    """A light group.

    Attributes
    ----------
    name
        The group's.
    bodies
        Its emitters, each with the number by which sample points know it.
    shapes
        `mitsuba.ShapePtr` of those that rays can hit, each with its emitter.
    """

    name: str
    bodies: list[tuple[int, Emitter]]
    shapes: list[tuple[Any, Emitter]] = field(default_factory=list)

    def shape_ids(self) -> list[str]:
        """Name the bodies in Mitsuba's scene."""
        return [f"lamp_{self.name}_{k}" for k, _ in self.bodies]

    def hits(self, si: Any, ray: Any) -> list[tuple[Any, Emitter]]:
        """Say for each body whether the rays meet its shining side."""
        towards = si.is_valid() & (dr.dot(si.n, ray.d) < 0)
        return [(towards & (si.shape == shape), body) for shape, body in self.shapes]


def lamps_of(specs: tuple[LampSpec, ...]) -> list[Lamp]:
    """Build all lamps, their bodies numbered through."""
    lamps, number = [], 0
    for spec in specs:
        bodies = emitters_of(spec)
        lamps.append(Lamp(spec.name, list(enumerate(bodies, start=number))))
        number += len(bodies)
    return lamps


def pointer(shape: Any) -> Any:
    """Point to a shape; its number is kept out of the kernels, which it would change."""
    found = mi.ShapePtr(shape)
    dr.make_opaque(found)
    return found


def bind(lamps: list[Lamp], shapes: dict[str, Any]) -> None:
    """Find the lamps' shapes in a loaded scene, by their names."""
    for lamp in lamps:
        for name, (_, body) in zip(lamp.shape_ids(), lamp.bodies, strict=True):
            if name in shapes:
                lamp.shapes.append((pointer(shapes[name]), body))
