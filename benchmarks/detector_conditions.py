"""What detectors are tried on: the nominal scene and its changes, hard images, lossy storage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from lossy_storage import Picture, jpeg, mpeg4

from simtip import SceneSpec, load_scene
from simtip.seeding import stream

SCENES = Path(__file__).resolve().parents[1] / "scenes"
STROKE_MM = (28.0, 22.0, 15.0)
"""Of the paper's robot: tips lie anywhere in a box of this size about the scene's own."""
SIZE_PX = (320, 800)
"""Width and height of what is read out around the tip: enough shaft for the paper's least area of
4500 px, even where a highlight takes half of it."""
ABOVE = 0.88
"""Part of it above the tip."""
TIP_Z_MM = 170.0
LESS_QUIET = 0.5
"""Monte-Carlo noise of all but the nominal scenes, of the sensor's own: it widens the scatter
between poses by an eighth at most."""
BEVEL = {"kind": "bevel", "angle_deg": 20}


@dataclass(frozen=True)
class Condition:
    """One row of the table.

    Attributes
    ----------
    name, group
        What is printed, and under which heading.
    scenes
        Each is rendered once; made when asked for.
    exposures
        So many pairs with fresh sensor noise of each scene.
    stored
        What happens to the images before they are looked at.
    """

    name: str
    group: str
    scenes: Callable[[], list[SceneSpec]]
    exposures: int
    stored: Callable[[Picture], Picture] | None = None


def conditions(poses: int, exposures: int) -> list[Condition]:
    """List all, in the order of the table.

    Parameters
    ----------
    poses
        Of the nominal scenes; their changes have a third of them.
    exposures
        Of every pose.
    """
    few = max(1, poses // 3)
    some = partial(_varied, poses=few, exposures=exposures, noise=LESS_QUIET)
    pair = partial(_varied, poses=poses, exposures=exposures)
    return [
        pair("cone, pinholes", "nominal", {}, base="01_single_tip"),
        pair("cone, real camera", "nominal", {}),
        pair("bevel, real camera", "nominal", {"needle": {"tip": BEVEL}}),
        *(
            some(f"{mm:+d} mm", "defocus", {"rig": _focus(TIP_Z_MM + mm)})
            for mm in (-14, -7, 0, 7, 14)
        ),
        *(
            some(f"{dn} DN", "background", {"sensor": {"background_dn": dn}})
            for dn in (120, 150, 180, 220)
        ),
        *(
            some(f"{a:g}", "roughness", {"needle": {"material": {"roughness": a}}})
            for a in (0.05, 0.1, 0.2, 0.4)
        ),
        *(some(name, "lamps", {"lamps": lamps}) for name, lamps in _lamps().items()),
        some("JPEG, quality 40", "storage", {}, stored=jpeg),
        some("MPEG-4", "storage", {}, stored=mpeg4),
        *(
            Condition(file.stem, "hard", partial(_alone, file), exposures)
            for file in sorted((SCENES / "hard").glob("*.yaml"))
        ),
    ]


def _varied(
    name: str,
    group: str,
    changes: dict[str, Any],
    poses: int,
    exposures: int,
    *,
    noise: float = 0.3,
    base: str = "02_real_camera",
    stored: Callable[[Picture], Picture] | None = None,
) -> Condition:
    return Condition(name, group, partial(_posed, base, changes, poses, noise), exposures, stored)


def _posed(base: str, changes: dict[str, Any], poses: int, noise: float) -> list[SceneSpec]:
    """Give a scene changed and at random places and rolls, the same ones for every condition."""
    data = load_scene(SCENES / f"{base}.yaml").model_dump(mode="json", exclude_unset=True)
    _change(data, {"render": {"noise": noise}})
    _change(data, changes)
    made = []
    for number in range(poses):
        rng = stream(1, "detector poses", number)
        offset = (rng.random(3) - 0.5) * STROKE_MM
        data["needle"] |= {
            "tip_mm": (np.array([-10, 20, 170]) + offset).tolist(),
            "roll_deg": float(rng.random() * 360),
        }
        data["seed"] = number + 1
        made.append(read_out(SceneSpec.model_validate(data)))
    return made


def _alone(file: Path) -> list[SceneSpec]:
    return [load_scene(file)]


def read_out(scene: SceneSpec) -> SceneSpec:
    """Give the scene with the region of each sensor around the needle's tip read out."""
    data = scene.model_dump(mode="json")
    tips = scene.rig.rig().project(np.array(scene.needle.tip_mm))
    width, height = SIZE_PX
    for side, (u, v) in zip(("left", "right"), tips, strict=True):
        data["rig"][side]["roi"] = [
            *(round(u) - width // 2, round(v) - round(ABOVE * height)),
            *SIZE_PX,
        ]
    return SceneSpec.model_validate(data)


def _change(data: dict[str, Any], changes: dict[str, Any]) -> None:
    """Change a scene in depth; lists and parts of another kind are replaced."""
    for key, value in changes.items():
        if isinstance(value, dict) and "kind" not in value:
            _change(data.setdefault(key, {}), value)
        else:
            data[key] = value


def _focus(focus_mm: float) -> dict[str, Any]:
    return {side: {"lens": {"focus_mm": focus_mm}} for side in ("left", "right")}


def _lamps() -> dict[str, list[dict[str, Any]]]:
    """Give four layouts: the paper's tubes, tubes along the view, a troffer, a panel."""
    tube = {"kind": "tube", "direction": [0, 0, 1]}
    return {
        "tubes across": [
            {"name": "front", "kind": "tube", "centre_mm": [0, -1500, -600]},
            {"name": "rear", "kind": "tube", "centre_mm": [0, -1500, -1800]},
        ],
        "tubes along": [
            {"name": "left", "centre_mm": [-700, -1500, -300], **tube},
            {"name": "right", "centre_mm": [700, -1500, -300], **tube},
        ],
        "troffer": [{"name": "troffer", "kind": "troffer", "centre_mm": [300, -1200, -500]}],
        "panel at one side": [
            {
                "name": "panel",
                "kind": "panel",
                "centre_mm": [-700, -300, -400],
                "normal": [0.75, 0.3, 0.6],
                "direction": [0, 1, 0],
                "size_mm": [300, 300],
            }
        ],
    }
