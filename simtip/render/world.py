"""From a scene's data to Mitsuba's scene, with handles to its parts.

World units are millimetres; radiance is per unit lamp radiance (see `simtip.render.transport`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from simtip.clutter import ClutterObject
from simtip.render.board import Board
from simtip.render.engine import dr, mi
from simtip.render.lamps import Lamp, bind, lamps_of, pointer
from simtip.render.mesh import mesh_of
from simtip.render.subject import Subject
from simtip.render.surround import EvenRoom, Surround, WalledRoom
from simtip.seeding import seed32
from simtip.spec import BackgroundSpec, SceneSpec

BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
COAT_INDEX = 1.5
"""Refractive index of glossy clutter's coat, as of most plastics and lacquers (1.4 to 1.6): chosen,
so that it mirrors 0.04 of what falls on it squarely."""

COAT_ROUGHNESS = 0.15
"""GGX alpha of the coat, chosen: a tube's image on a cable is a streak, no mirror image."""

_INDEX = {"int_ior": COAT_INDEX, "ext_ior": 1.0}
_COAT: dict[str, Any] = {
    "type": "roughplastic",
    "distribution": "ggx",
    "alpha": COAT_ROUGHNESS,
    **_INDEX,
    "diffuse_reflectance": {"type": "rgb", "value": 0.0},
}

GLOW = {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}


@dataclass(frozen=True)
class Thing:
    """A piece of clutter: `mitsuba.ShapePtr`, whether it belongs in the picture, and is coated."""

    shape: Any
    in_view: bool
    glossy: bool


@dataclass(frozen=True)
class World:
    """A loaded scene.

    Attributes
    ----------
    scene
        `mitsuba.Scene`.
    subject
        What stands before the cameras.
    background
        `mitsuba.ShapePtr`.
    board
        The background's plane.
    board_normal
        Its normal as the renderer reads it.
    lamps
        The light groups.
    surround
        What lies around.
    clutter
        Solid things that are neither subject nor background.
    coat
        `mitsuba.BSDF` of glossy clutter's coat alone; None where there is no such clutter.
    """

    scene: Any
    subject: Subject
    background: Any
    board: Board
    board_normal: Any
    lamps: list[Lamp]
    surround: Surround
    clutter: list[Thing]
    coat: Any


def _background(background: BackgroundSpec) -> dict[str, Any]:
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(Board.of(background).matrix().tolist()),
        "bsdf": {
            "type": "diffuse",
            "reflectance": {"type": "rgb", "value": list(background.albedo)},
        },
    }


def _bodies(lamp: Lamp, *, lit: bool) -> dict[str, Any]:
    """Describe a lamp's bodies that rays can hit: black, and shining if lit."""
    found = {}
    for name, (_, body) in zip(lamp.shape_ids(), lamp.bodies, strict=True):
        shape = body.shape()
        if shape is not None:
            found[name] = {**shape, "bsdf": BLACK, **({"emitter": GLOW} if lit else {})}
    return found


def surroundings(spec: SceneSpec, lamps: list[Lamp], lit: str | None = None) -> dict[str, Any]:
    """Describe the background, the lamps' bodies and, if it is lit, the ambient light."""
    scene: dict[str, Any] = {
        "type": "scene",
        "background": _background(spec.background),
    }
    for lamp in lamps:
        scene |= _bodies(lamp, lit=lamp.name == lit)
    if lit == "ambient":
        scene["ambient"] = {**GLOW, "type": "constant"}
    return scene


def load_world(
    spec: SceneSpec, seed: int, subject: Subject, clutter: Sequence[ClutterObject] = ()
) -> World:
    """Load the scene for the wavefront renderer, which integrates the lamps itself.

    Parameters
    ----------
    spec
        The scene.
    seed
        Of the samples that light the room's walls.
    subject
        What stands before the cameras.
    clutter
        Its solid clutter.
    """
    lamps = lamps_of(spec.lamps)
    things = {
        f"clutter_{k}": mesh_of(f"clutter_{k}", thing.vertices, thing.faces, {"bsdf": _body(thing)})
        for k, thing in enumerate(clutter)
    }
    scene = mi.load_dict(
        {**surroundings(spec, lamps), **subject.shapes(), **things}, parallel=False
    )
    shapes = {shape.id(): shape for shape in scene.shapes()}
    bind(lamps, shapes)
    board = Board.of(spec.background)
    subject.bind(shapes)
    return World(
        scene=scene,
        subject=subject,
        background=pointer(shapes["background"]),
        board=board,
        board_normal=mi.Normal3f([dr.opaque(mi.Float, float(v)) for v in board.normal]),
        lamps=lamps,
        surround=(
            EvenRoom(len(lamps))
            if spec.room is None or not lamps  # unlit walls add nothing
            else WalledRoom(spec.room, lamps, seed32(seed, "walls"))
        ),
        clutter=[
            Thing(pointer(shapes[name]), thing.in_view, thing.finish == "glossy")
            for name, thing in zip(things, clutter, strict=True)
        ],
        coat=mi.load_dict(_COAT) if any(thing.finish == "glossy" for thing in clutter) else None,
    )


def _body(thing: ClutterObject) -> dict[str, Any]:
    """Describe what clutter is made of, under its coat if it has one.

    Mitsuba's smooth plastic weakens light on its way in and out by Fresnel's laws, and keeps inside
    what its surface throws back; only its diffuse part is used. (The diffuse part of its rough
    plastic loses 15 % of the light.)
    """
    albedo = {"type": "rgb", "value": thing.albedo.tolist()}
    if thing.finish == "matt":
        return {"type": "diffuse", "reflectance": albedo}
    return {"type": "plastic", **_INDEX, "diffuse_reflectance": albedo}
