"""Scenes cut down to what a test looks at."""

from __future__ import annotations

from simtip.spec import SceneSpec


def with_roi(scene: SceneSpec, left: list[int], right: list[int], **render: object) -> SceneSpec:
    """Read out only a region of each sensor; `render` overrides that part of the scene."""
    data = scene.model_dump(mode="json")
    data["rig"]["left"]["roi"], data["rig"]["right"]["roi"] = left, right
    data["render"].update(render)
    return SceneSpec.model_validate(data)
