"""From a scene's data to Mitsuba's scene, with handles to its parts.

World units are millimetres; radiance is per unit lamp radiance (see `simtip.render.transport`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.clutter import ClutterObject
from simtip.geometry import Array, Pose, unit
from simtip.needle import Faces, Needle
from simtip.render.board import Board
from simtip.render.engine import dr, mi
from simtip.render.lamps import Lamp, bind, lamps_of, pointer
from simtip.render.metal import channel_index, film_tint
from simtip.render.surround import EvenRoom, Surround, WalledRoom
from simtip.seeding import seed32
from simtip.spec import BackgroundSpec, NeedleMaterial, SceneSpec, SensorSpec

BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
LEAST_SINE = 1e-3
"""Where the needle's face is square to the brushing there is no direction."""

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
    needle
        `mitsuba.ShapePtr` of the needle, an instance.
    background
        `mitsuba.ShapePtr`.
    metal
        `mitsuba.BSDF` of the needle.
    brush
        Direction along which the needle is brushed, or None.
    board
        The background's plane.
    board_normal
        Its normal as the renderer reads it.
    lamps
        The light groups.
    surround
        What lies around.
    clutter
        Solid things that are neither needle nor background.
    coat
        `mitsuba.BSDF` of glossy clutter's coat alone; None where there is no such clutter.
    """

    scene: Any
    needle: Any
    background: Any
    metal: Any
    brush: Any
    board: Board
    board_normal: Any
    lamps: list[Lamp]
    surround: Surround
    clutter: list[Thing]
    coat: Any

    def brushed(self, si: Any, ray: Any) -> Any:
        """Turn the interaction's frame so that its second axis runs along the brushing."""
        if self.brush is None:
            return si
        across = dr.cross(self.brush, si.sh_frame.n)
        length = dr.norm(across)
        there = length > LEAST_SINE
        s = dr.select(there, across / length, si.sh_frame.s)
        si.sh_frame.s = s
        si.sh_frame.t = dr.cross(si.sh_frame.n, s)
        si.wi = si.to_local(-ray.d)
        return si


def needle_mesh(needle: Needle, T_an: Pose, parts: dict[str, Any]) -> Any:
    """Load the needle's mesh, in some frame a, with its material (and light).

    The faces are flat: there are enough of them (`simtip.needle.SEGMENTS`).
    """
    vertices, faces = needle.surface()
    return mesh_of("needle", T_an.apply(vertices), faces, parts)


def metal_bsdf(material: NeedleMaterial, sensor: SensorSpec) -> Any:
    """Build the needle's rough conductor from measured n and k, as the sensor's channels see it."""
    n, k = channel_index(material.metal, sensor)
    alpha = (
        {"alpha": material.roughness}
        if material.roughness_along is None
        else {"alpha_u": material.roughness, "alpha_v": material.roughness_along}
    )
    tint = film_tint(n, k, material.oxide_nm, sensor)
    film: dict[str, Any] = {}
    if tint is not None:
        # A film may reflect more than the bare metal, which Mitsuba refuses unless told.
        film = {"specular_reflectance": {"type": "srgb", "color": tint.tolist(), "unbounded": True}}
    return mi.load_dict(
        {
            "type": "roughconductor",
            "distribution": "ggx",
            **alpha,
            **film,
            "eta": {"type": "rgb", "value": n.tolist()},
            "k": {"type": "rgb", "value": k.tolist()},
        }
    )


def _board(background: BackgroundSpec) -> dict[str, Any]:
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


def mesh_of(name: str, vertices: Array, faces: Faces, parts: dict[str, Any]) -> Any:
    """Load a mesh with its material (and light). Its faces are flat."""
    props = mi.Properties()
    for key, part in parts.items():
        props[key] = mi.load_dict(part) if isinstance(part, dict) else part
    shape = mi.Mesh(name, len(vertices), len(faces), props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = np.ascontiguousarray(vertices, dtype=np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(faces, dtype=np.uint32).ravel()
    parameters.update()
    return shape


def _plain_needle(spec: SceneSpec, parts: dict[str, Any]) -> dict[str, Any]:
    return {"needle": needle_mesh(spec.needle.needle(), spec.needle.pose(), parts)}


def _instanced_needle(spec: SceneSpec, metal: Any) -> dict[str, Any]:
    """Describe the needle as an instance of a mesh in the needle's own frame.

    Only there are boxes around the mesh's long thin triangles tight: rays at a tilted mesh took
    ten times as long. (The scalar variant needs none of this, and crashes on it.)
    """
    mesh = needle_mesh(spec.needle.needle(), Pose.identity(), {"bsdf": metal})
    return {
        "needle_group": {"type": "shapegroup", "mesh": mesh},
        "needle": {
            "type": "instance",
            "to_world": mi.ScalarTransform4f(spec.needle.pose().matrix().tolist()),
            "shapegroup": {"type": "ref", "id": "needle_group"},
        },
    }


def _surroundings(spec: SceneSpec, lamps: list[Lamp], lit: str | None = None) -> dict[str, Any]:
    scene: dict[str, Any] = {
        "type": "scene",
        "background": _board(spec.background),
    }
    for lamp in lamps:
        scene |= _bodies(lamp, lit=lamp.name == lit)
    if lit == "ambient":
        scene["ambient"] = {**GLOW, "type": "constant"}
    return scene


def stock_scene(spec: SceneSpec, lit: str, metal: Any = None) -> dict[str, Any]:
    """Describe the scene to Mitsuba's own integrators.

    Parameters
    ----------
    spec
        The scene.
    lit
        The lamp, "ambient" or "needle" that is an emitter, of unit radiance.
    metal
        The needle's material, a BSDF or its dictionary, if not the scene's.
    """
    parts = {"bsdf": metal or metal_bsdf(spec.needle.material, spec.sensor)}
    if lit == "needle":
        parts["emitter"] = GLOW
    return {**_surroundings(spec, lamps_of(spec.lamps), lit), **_plain_needle(spec, parts)}


def load_world(spec: SceneSpec, seed: int, clutter: Sequence[ClutterObject] = ()) -> World:
    """Load the scene for the wavefront renderer, which integrates the lamps itself.

    Parameters
    ----------
    spec
        The scene.
    seed
        Of the samples that light the room's walls.
    clutter
        Its solid clutter.
    """
    metal = metal_bsdf(spec.needle.material, spec.sensor)
    lamps = lamps_of(spec.lamps)
    things = {
        f"clutter_{k}": mesh_of(f"clutter_{k}", thing.vertices, thing.faces, {"bsdf": _body(thing)})
        for k, thing in enumerate(clutter)
    }
    scene = mi.load_dict(
        {**_surroundings(spec, lamps), **_instanced_needle(spec, metal), **things}, parallel=False
    )
    shapes = {shape.id(): shape for shape in scene.shapes()}
    bind(lamps, shapes)
    board = Board.of(spec.background)
    brush = None
    if spec.needle.material.roughness_along is not None:
        axis = unit(np.array(spec.needle.axis))
        brush = mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in axis])
    return World(
        scene=scene,
        needle=pointer(shapes["needle"]),
        background=pointer(shapes["background"]),
        metal=metal,
        brush=brush,
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
