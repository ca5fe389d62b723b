"""Scenes for boards, cut down to what a test looks at."""

from __future__ import annotations

import numpy as np

from simtip.geometry import Pose
from simtip.spec import SceneSpec

SMALL = {
    "target": "chessboard:3x3:1.5",
    "views": 3,
    "plate": {"margin_mm": 0.5, "thickness_mm": 0.5},
    "poses": {"depth_mm": 2.0, "tilt_deg": [5, 25], "margin_px": 1},
}
"""A board that fits into the regions of interest of `small`."""


def changed(scene: SceneSpec, **parts: dict | list) -> SceneSpec:
    """Update parts of a scene by their names, one level deep; lists are replaced."""
    data = scene.model_dump(mode="json")
    for name, part in parts.items():
        data[name] = data[name] | part if isinstance(part, dict) else part
    return SceneSpec.model_validate(data)


def even(scene: SceneSpec) -> SceneSpec:
    """Light it from everywhere alike: what a matt surface gives back is its albedo."""
    return changed(scene, lamps=[], ambient={"radiance_w_m2_sr": [1, 1, 1]})


def small(scene: SceneSpec, **boards: object) -> SceneSpec:
    """Read out 140 x 140 px about the needle's tip in both views, and hold a small board there."""
    rig = scene.model_dump(mode="json")["rig"]
    rig["left"]["roi"], rig["right"]["roi"] = [750, 780, 140, 140], [960, 780, 140, 140]
    return changed(
        scene, rig=rig, render={"noise": None, "samples": 16}, boards=SMALL | boards
    )  # fmt: skip


def lens(scene: SceneSpec, left: dict, right: dict) -> SceneSpec:
    """Give the two cameras other lenses."""
    rig = scene.model_dump(mode="json")["rig"]
    rig["left"]["lens"] |= left
    rig["right"]["lens"] |= right
    return changed(scene, rig=rig)


def cameras(scene: SceneSpec) -> list[tuple]:
    """Give camera and T_cw, left and right."""
    rig = scene.rig.rig()
    return [(rig.left, Pose.identity()), (rig.right, rig.T_lr.inverse())]


def regions_at(scene: SceneSpec, points_mm: list, size: int) -> SceneSpec:
    """Read out squares about where each camera sees its point (left's, right's), world mm."""
    rig = scene.model_dump(mode="json")["rig"]
    for side, (camera, T_cw), point in zip(
        ("left", "right"), cameras(scene), points_mm, strict=True
    ):
        u, v = np.rint(camera.project(T_cw.apply(point)) - size / 2).astype(int)
        rig[side]["roi"] = [int(u), int(v), size, size]
    return changed(scene, rig=rig)
