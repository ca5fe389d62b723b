"""What of a scene decides its bound: all else can change, and the bound still holds."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from simtip.spec import SceneSpec

WHOLE_PARTS = ("needle", "background", "clutter", "lamps", "ambient", "room", "sensor")
"""Parts of a scene that count with all their fields."""

RENDER_FIELDS = ("light_step_mm", "crop")
"""Of `render`: the bound takes samples of its own."""

PARTS = ("rig", *WHOLE_PARTS, "render", "seed")
"""Names of the parts that `bound_inputs` tells apart."""


def bound_inputs(spec: SceneSpec, seed: int | None = None) -> dict[str, Any]:
    """Give the part of a scene that its bound depends on, as plain data by `PARTS`.

    The detector, matching, triangulation, refinement, the rig that measures, boards and noise asked
    of the renderer are not in it. The seed is, where it decides what is seen: clutter, paper,
    wrinkles.

    Parameters
    ----------
    spec
        The scene, as given: its exposure not settled.
    seed
        Root of clutter and paper; by default the scene's own.
    """
    data = spec.model_dump(mode="json")
    rooted = spec.seed if seed is None else seed
    return {
        "rig": {key: value for key, value in data["rig"].items() if key != "measured"},
        **{part: data[part] for part in WHOLE_PARTS},
        "render": {key: data["render"][key] for key in RENDER_FIELDS},
        "seed": rooted if _shows_chance(spec) else None,
    }


def bound_digests(spec: SceneSpec, seed: int | None = None) -> dict[str, str]:
    """Give the SHA-256, in hexadecimal, of each part of `bound_inputs`.

    One a part, so that a bound of another scene can be told what differs.
    """
    return {part: _digest(value) for part, value in bound_inputs(spec, seed).items()}


def _shows_chance(spec: SceneSpec) -> bool:
    """Say whether anything is seen that the seed places."""
    board, amounts = spec.background, spec.clutter.amounts()
    return board.paper is not None or board.wrinkles is not None or amounts != type(amounts)()


def _digest(value: Any) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
