"""From a scene's data to Mitsuba's scene, with handles to its parts.

World units are millimetres; radiance is per unit lamp radiance (see `simtip.render.transport`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from simtip.geometry import Array, Pose, unit
from simtip.needle import Needle
from simtip.render.board import Board
from simtip.render.engine import dr, mi
from simtip.render.metal import METALS, at_wavelengths
from simtip.render.tube import Tube
from simtip.spec import BackgroundSpec, NeedleMaterial, SceneSpec, TubeLamp

GLOW = {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}


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
    albedo
        (3,) of the background.
    board, board_normal
        The background's plane, and its normal as the renderer reads it.
    tubes
        The lamps.
    """

    scene: Any
    needle: Any
    background: Any
    metal: Any
    albedo: Array
    board: Board
    board_normal: Any
    tubes: tuple[Tube, ...]


def needle_mesh(needle: Needle, T_an: Pose, parts: dict[str, Any]) -> Any:
    """Load the needle's mesh, in some frame a, with its material (and light).

    The faces are flat: there are enough of them (`simtip.needle.SEGMENTS`).
    """
    vertices, faces = needle.surface()
    vertices = T_an.apply(vertices)
    props = mi.Properties()
    for key, part in parts.items():
        props[key] = mi.load_dict(part) if isinstance(part, dict) else part
    shape = mi.Mesh("needle", len(vertices), len(faces), props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = np.ascontiguousarray(vertices, dtype=np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(faces, dtype=np.uint32).ravel()
    parameters.update()
    return shape


def metal_bsdf(material: NeedleMaterial, wavelength_nm: tuple[float, float, float]) -> Any:
    """Build the needle's rough conductor from measured n and k at the channels' wavelengths."""
    n, k = at_wavelengths(METALS[material.metal], wavelength_nm)
    return mi.load_dict(
        {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": material.roughness,
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


def _tube(lamp: TubeLamp, *, lit: bool) -> dict[str, Any]:
    half = unit(np.array(lamp.direction)) * lamp.length_mm / 2
    centre = np.array(lamp.centre_mm)
    shape: dict[str, Any] = {
        "type": "cylinder",
        "p0": (centre - half).tolist(),
        "p1": (centre + half).tolist(),
        "radius": lamp.diameter_mm / 2,
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
    }
    if lit:
        shape["emitter"] = GLOW
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


def _surroundings(spec: SceneSpec, lit: str | None = None) -> dict[str, Any]:
    scene: dict[str, Any] = {
        "type": "scene",
        "background": _board(spec.background),
    }
    for lamp in spec.lamps:
        scene[f"lamp_{lamp.name}"] = _tube(lamp, lit=lamp.name == lit)
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
    parts = {"bsdf": metal or metal_bsdf(spec.needle.material, spec.sensor.wavelength_nm)}
    if lit == "needle":
        parts["emitter"] = GLOW
    return {**_surroundings(spec, lit), **_plain_needle(spec, parts)}


def load_world(spec: SceneSpec) -> World:
    """Load the scene for the wavefront renderer, which integrates the lamps itself."""
    metal = metal_bsdf(spec.needle.material, spec.sensor.wavelength_nm)
    scene = mi.load_dict({**_surroundings(spec), **_instanced_needle(spec, metal)}, parallel=False)
    by_name = {shape.id(): shape for shape in scene.shapes()}
    tubes = []
    for lamp in spec.lamps:
        tube = Tube(lamp)
        tube.shape = mi.ShapePtr(by_name[f"lamp_{lamp.name}"])
        tubes.append(tube)
    board = Board.of(spec.background)
    return World(
        scene=scene,
        needle=mi.ShapePtr(by_name["needle"]),
        background=mi.ShapePtr(by_name["background"]),
        metal=metal,
        albedo=np.array(spec.background.albedo),
        board=board,
        board_normal=mi.Normal3f([dr.opaque(mi.Float, float(v)) for v in board.normal]),
        tubes=tuple(tubes),
    )
