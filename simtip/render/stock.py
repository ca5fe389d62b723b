"""A scene as Mitsuba's own integrators take it: what the scalar back end and benchmarks render."""

from __future__ import annotations

from typing import Any

from simtip.render.lamps import lamps_of
from simtip.render.needle_subject import metal_bsdf, needle_mesh
from simtip.render.world import GLOW, surroundings
from simtip.spec import SceneSpec


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
    # The scalar variant crashes on instances, so here the needle is a plain mesh.
    parts = {"bsdf": metal or metal_bsdf(spec.needle.material, spec.sensor)}
    if lit == "needle":
        parts["emitter"] = GLOW
    return {
        **surroundings(spec, lamps_of(spec.lamps), lit),
        "needle": needle_mesh(spec.needle.needle(), spec.needle.pose(), parts),
    }
