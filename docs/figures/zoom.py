"""The part of a scene around its tip, for figures that enlarge it."""

from __future__ import annotations

import numpy as np

from simtip.spec import SceneSpec


def around_the_tip(scene: SceneSpec, size_px: tuple[int, int], above: float) -> SceneSpec:
    """Read out only the part around the tip of the left image, and little of the right one.

    Parameters
    ----------
    scene
        The scene.
    size_px
        Width and height of the part.
    above
        Part of the height that lies above the tip.
    """
    u, v = scene.rig.rig().left.project(np.array(scene.needle.tip_mm))
    width, height = size_px
    roi = (round(u) - width // 2, round(v) - round(above * height), width, height)
    left = scene.rig.left.model_copy(update={"roi": roi})
    right = scene.rig.right.model_copy(update={"roi": (0, 0, 64, 64)})
    rig = scene.rig.model_copy(update={"left": left, "right": right})
    return scene.model_copy(update={"rig": rig})
