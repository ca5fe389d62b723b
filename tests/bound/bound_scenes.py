"""Variants of a scene for the bound."""

from __future__ import annotations

from simtip.spec import SceneSpec


def changed(scene: SceneSpec, **parts: dict | list) -> SceneSpec:
    """Change fields of a scene's parts, checked anew."""
    data = scene.model_dump()
    for name, part in parts.items():
        data[name] = {**data[name], **part} if isinstance(part, dict) else part
    return SceneSpec.model_validate(data)


def square_pixels(scene: SceneSpec) -> SceneSpec:
    """Make fy = fx, as Mitsuba's own camera has it."""
    rig = scene.model_dump()["rig"]
    for side in ("left", "right"):
        rig[side]["fy"] = rig[side]["fx"]
    return changed(scene, rig=rig)
