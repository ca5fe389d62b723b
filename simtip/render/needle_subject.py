"""The needle before the cameras: rough metal, which mirrors lamps, room, background and clutter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import override

from simtip.camera import Camera
from simtip.footprint import footprint
from simtip.geometry import Array, Pose, unit
from simtip.needle import Needle
from simtip.render.engine import dr, mi
from simtip.render.lamps import pointer
from simtip.render.mesh import mesh_of
from simtip.render.metal import channel_index, film_tint
from simtip.render.subject import Mask, Pixels, Subject
from simtip.render.transport import reflected
from simtip.spec import NeedleMaterial, SceneSpec, SensorSpec

if TYPE_CHECKING:
    from simtip.render.backdrop import Backdrop
    from simtip.render.eye import Eye
    from simtip.render.lighting import Lighting
    from simtip.render.sobol import Points
    from simtip.render.world import World

LEAST_SINE = 1e-3
"""Where the needle's face is square to the brushing there is no direction."""

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


class NeedleSubject(Subject):
    """A scene's needle.

    It is an instance of a mesh in the needle's own frame: only there are boxes around the mesh's
    long thin triangles tight, and rays at a tilted mesh took ten times as long.
    """

    def __init__(self, spec: SceneSpec) -> None:
        self._needle, self._T_wn = spec.needle.needle(), spec.needle.pose()
        self._metal = metal_bsdf(spec.needle.material, spec.sensor)
        self._shape: Any = None
        self._axis = unit(np.array(spec.needle.axis))
        self._brushed_along = spec.needle.material.roughness_along is not None
        self._brush: Any = _vector(self._axis) if self._brushed_along else None

    @override
    def vertices(self) -> Array:
        """Give its mesh's points (n, 3), world, mm."""
        return self._T_wn.apply(self._needle.surface()[0])

    @override
    def footprint(self, T_cw: Pose, camera: Camera, margin_px: float) -> Mask:
        """Mark every pixel (H, W) that it may touch, and all within a margin of those."""
        return footprint(self._needle, T_cw @ self._T_wn, camera, margin_px)

    @override
    def shapes(self) -> dict[str, Any]:
        """Describe the instance and its mesh."""
        mesh = needle_mesh(self._needle, Pose.identity(), {"bsdf": self._metal})
        return {
            "needle_group": {"type": "shapegroup", "mesh": mesh},
            "needle": {
                "type": "instance",
                "to_world": mi.ScalarTransform4f(self._T_wn.matrix().tolist()),
                "shapegroup": {"type": "ref", "id": "needle_group"},
            },
        }

    @override
    def bind(self, shapes: dict[str, Any]) -> None:
        """Take hold of the instance."""
        self._shape = pointer(shapes["needle"])

    def move(self, scene: Any, move: Pose) -> None:
        """Move it in a loaded scene, away from where the scene's data has it.

        Parameters
        ----------
        scene
            `mitsuba.Scene` with this needle.
        move
            From where a point of it was in the world to where it is, mm; the identity puts it back.
            `footprint` and `vertices` stay those of where it was.
        """
        parameters = mi.traverse(scene)
        matrix = (move @ self._T_wn).matrix().tolist()
        parameters["needle.to_world"] = type(parameters["needle.to_world"])(matrix)
        parameters.update()
        if self._brushed_along:
            self._brush = _vector(move.rotate(self._axis))

    @override
    def light(self, lighting: Lighting) -> None:
        """Do nothing: its light is sampled ray by ray."""

    @override
    def plain(self, eye: Eye, pixels: Pixels, blur_px: float) -> Mask:
        """Say that nothing is known to be smooth."""
        return np.zeros(len(pixels), np.bool_)

    @override
    def met(self, si: Vec) -> Vec:
        """Say which rays meet it."""
        return si.is_valid() & (si.instance == self._shape)

    @override
    def slipped(self, hit: Vec, ray: Vec) -> Vec:
        """Say which rays met its far wall from inside."""
        return self.met(hit) & (dr.dot(hit.n, ray.d) > 0)

    @override
    def radiance(
        self, world: World, backdrop: Backdrop, ray: Vec, si: Vec, points: Points, active: Vec
    ) -> list[Vec]:
        """Give what it mirrors, per light group."""
        si = self._brushed(si, ray)
        return reflected(world, backdrop, self._metal, si, points, points.lobe(), active)

    def _brushed(self, si: Vec, ray: Vec) -> Vec:
        """Turn the interaction's frame so that its second axis runs along the brushing."""
        if self._brush is None:
            return si
        across = dr.cross(self._brush, si.sh_frame.n)
        length = dr.norm(across)
        there = length > LEAST_SINE
        s = dr.select(there, across / length, si.sh_frame.s)
        si.sh_frame.s = s
        si.sh_frame.t = dr.cross(si.sh_frame.n, s)
        si.wi = si.to_local(-ray.d)
        return si


def _vector(values: Array) -> Any:
    return mi.Vector3f([dr.opaque(mi.Float, float(v)) for v in values])


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
