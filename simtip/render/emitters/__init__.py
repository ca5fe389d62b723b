"""The shining bodies of a lamp, by its kind."""

from __future__ import annotations

import numpy as np

from simtip.render.emitters.bulb import Bulb
from simtip.render.emitters.panel import Panel
from simtip.render.emitters.sample import Emitter, LampSample
from simtip.render.emitters.tube import Tube
from simtip.spec import LampSpec, PanelLamp, PointLamp, TrofferLamp, TubeLamp

__all__ = ["Emitter", "LampSample", "emitters_of"]


def emitters_of(lamp: LampSpec) -> list[Emitter]:
    """Build a lamp's shining bodies."""
    centre = np.array(lamp.centre_mm)
    match lamp:
        case TubeLamp():
            return [Tube(centre, np.array(lamp.direction), lamp.length_mm, lamp.diameter_mm)]
        case TrofferLamp():
            along = np.array(lamp.direction)
            return [
                Tube(place, along, lamp.length_mm, lamp.diameter_mm)
                for place in lamp.tube_centres()
            ]
        case PanelLamp():
            return [
                Panel(
                    centre, np.array(lamp.direction), np.array(lamp.normal), np.array(lamp.size_mm)
                )
            ]
        case PointLamp():
            return [Bulb(centre, lamp.diameter_mm)]
