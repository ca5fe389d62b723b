"""What clutter has to know of a scene."""

from __future__ import annotations

import numpy as np

from simtip.clutter import LampPlace, Setting
from simtip.geometry import Array, unit
from simtip.needle import Needle
from simtip.render.board import Board
from simtip.spec import LampSpec, SceneSpec, TrofferLamp, TubeLamp

AXIS_POINTS = 65


def clutter_setting(spec: SceneSpec) -> Setting:
    """Describe the scene around the clutter; whole sensors, so that no region of it counts."""
    T_wn = spec.needle.pose()
    needle = spec.needle.needle()
    rig = spec.rig.model_copy(
        update={
            "left": spec.rig.left.model_copy(update={"roi": None}),
            "right": spec.rig.right.model_copy(update={"roi": None}),
        }
    )
    return Setting(
        board=Board.of(spec.background),
        rig=rig.rig(),
        tip_mm=T_wn.apply(needle.apex),
        needle_mm=T_wn.apply(_axis(needle)),
        needle_radius_mm=needle.radius_mm,
        lamps=[_place(lamp) for lamp in spec.lamps],
    )


def _axis(needle: Needle) -> Array:
    """Give points (n, 3) along the axis, needle frame, close enough to be joined by lines."""
    z = np.linspace(0, needle.length_mm, 2 if needle.bend is None else AXIS_POINTS)
    points = np.stack([np.zeros_like(z), np.zeros_like(z), z], axis=-1)
    return points if needle.bend is None else needle.bend.apply(points)


def _place(lamp: LampSpec) -> LampPlace:
    half = np.zeros(3)
    if isinstance(lamp, TubeLamp | TrofferLamp):
        half = unit(np.array(lamp.direction)) * lamp.length_mm / 2
    return LampPlace(np.array(lamp.centre_mm), half)
